// Random numbers for x86-64 with AVX-512.
#include "base/kernels/generic.hpp"

namespace decid {

const RandomKernels& avx512_random_kernels() {
  return random_table<Native>;
}

}  // namespace decid
