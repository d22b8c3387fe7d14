// The kernels of images for WebAssembly's relaxed vectors.
#include "dataset/image/kernels/generic.hpp"

namespace decid::dataset {

const ImageKernels& ImageTables::relaxed() {
  return image_table<Native>;
}

}  // namespace decid::dataset
