// The kernels of images for AArch64.
#include "dataset/image/kernels/generic.hpp"

namespace decid::dataset {

const ImageKernels& ImageTables::neon() {
  return image_table<Native>;
}

}  // namespace decid::dataset
