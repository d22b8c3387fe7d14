// Selects the image kernels of an instruction set; the plain kernels process one window at a time.
#include "base/kernels/table_for.hpp"
#include "dataset/image/kernels/generic.hpp"

namespace decid::dataset {

const ImageKernels& ImageTables::reference() {
  return image_table<One>;
}

const ImageKernels& image_kernels(Isa isa) {
  return table_for<ImageTables>(isa);
}

}  // namespace decid::dataset
