// The kernels of images for x86-64 with AVX-512.
#include "dataset/image/kernels/generic.hpp"

namespace decid::dataset {

const ImageKernels& avx512_image_kernels() {
  return image_table<Native>;
}

}  // namespace decid::dataset
