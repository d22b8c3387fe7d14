// The kernels of images for x86-64 with AVX2 and FMA (2013 on).
#include "dataset/image/kernels/generic.hpp"

namespace decid::dataset {

const ImageKernels& ImageTables::avx2() {
  return image_table<Native>;
}

}  // namespace decid::dataset
