// Random numbers for AArch64.
#include "base/kernels/generic.hpp"

namespace decid {

const RandomKernels& neon_random_kernels() {
  return random_table<Native>;
}

}  // namespace decid
