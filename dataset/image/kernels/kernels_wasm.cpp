// The kernels of images for WebAssembly's vectors.
#include "dataset/image/kernels/generic.hpp"

namespace decid::dataset {

const ImageKernels& ImageTables::wasm() {
  return image_table<Native>;
}

}  // namespace decid::dataset
