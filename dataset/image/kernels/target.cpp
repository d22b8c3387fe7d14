// The kernels of network input of one instruction set, DECID_TARGET: compiled once for each with its flags
// (decid_kernels in cmake/DecidTargets.cmake).
#include "dataset/image/kernels/generic.hpp"

namespace decid::dataset {

const ImageKernels& ImageTables::DECID_TARGET() {
  return image_table<Native>;
}

}  // namespace decid::dataset
