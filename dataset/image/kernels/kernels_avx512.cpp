// The kernels of images for x86-64 with AVX-512.
#include "dataset/image/kernels/generic.hpp"

namespace decid::dataset {

const ImageKernels& ImageTables::avx512() {
  return image_table<Native>;
}

}  // namespace decid::dataset
