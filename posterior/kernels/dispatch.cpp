// The kernels of an instruction set, and the plain ones: a lane at a time.
#include "base/kernels/table_of.hpp"
#include "posterior/kernels/generic.hpp"

namespace decid::posterior {

const Kernels& Tables::reference() {
  return kernel_table<One>;
}

const Kernels& kernels(Isa isa) {
  return table_of<Tables>(isa);
}

}  // namespace decid::posterior
