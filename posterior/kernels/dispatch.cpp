// Selects the kernels of an instruction set; the plain kernels process one lane at a time.
#include "base/kernels/table_for.hpp"
#include "posterior/kernels/generic.hpp"

namespace decid::posterior {

const Kernels& Tables::reference() {
  return kernel_table<One>;
}

const Kernels& kernels(Isa isa) {
  return table_for<Tables>(isa);
}

}  // namespace decid::posterior
