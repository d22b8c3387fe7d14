// The kernels of images for an instruction set, and the plain ones: a window at a time.
#include "dataset/image/kernels/generic.hpp"

namespace decid::dataset {

const ImageKernels& reference_image_kernels() {
  return image_table<One>;
}

const ImageKernels& image_kernels(Isa isa) {
  switch (isa) {
#if defined(__x86_64__)
    case Isa::baseline:
      return baseline_image_kernels();
    case Isa::avx2:
      return avx2_image_kernels();
    case Isa::avx512:
      return avx512_image_kernels();
#elif defined(__aarch64__)
    case Isa::neon:
      return neon_image_kernels();
#endif
    default:
      return reference_image_kernels();
  }
}

}  // namespace decid::dataset
