// The kernels of an instruction set, and the plain ones: a lane at a time.
#include "identify/posterior/kernels/generic.hpp"

namespace decid::posterior {

const Kernels& reference_kernels() {
  return kernel_table<One>;
}

const Kernels& kernels(Isa isa) {
  switch (isa) {
#if defined(__x86_64__)
    case Isa::baseline:
      return baseline_kernels();
    case Isa::avx2:
      return avx2_kernels();
    case Isa::avx512:
      return avx512_kernels();
#elif defined(__aarch64__)
    case Isa::neon:
      return neon_kernels();
#endif
    default:
      return reference_kernels();
  }
}

}  // namespace decid::posterior
