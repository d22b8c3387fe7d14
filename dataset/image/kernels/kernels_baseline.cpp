// The kernels of images for x86-64 as every such processor has it (SSE2).
#include "dataset/image/kernels/generic.hpp"

namespace decid::dataset {

const ImageKernels& ImageTables::baseline() {
  return image_table<Native>;
}

}  // namespace decid::dataset
