// Random numbers for AArch64.
#include "base/kernels/generic.hpp"

namespace decid {

const RandomKernels& RandomTables::neon() {
  return random_table<Native>;
}

}  // namespace decid
