// The kernels of an instruction set, and the plain ones: a number at a time.
#include "base/kernels/generic.hpp"

namespace decid {

const RandomKernels& reference_random_kernels() {
  return random_table<One>;
}

const RandomKernels& random_kernels(Isa isa) {
  switch (isa) {
#if defined(__x86_64__)
    case Isa::baseline:
      return baseline_random_kernels();
    case Isa::avx2:
      return avx2_random_kernels();
    case Isa::avx512:
      return avx512_random_kernels();
#elif defined(__aarch64__)
    case Isa::neon:
      return neon_random_kernels();
#endif
    default:
      return reference_random_kernels();
  }
}

}  // namespace decid
