// Selects the kernels of an instruction set; the plain kernels process one number at a time.
#include "base/kernels/generic.hpp"
#include "base/kernels/table_for.hpp"

namespace decid {

const RandomKernels& RandomTables::reference() {
  return random_table<One>;
}

const RandomKernels& random_kernels(Isa isa) {
  return table_for<RandomTables>(isa);
}

}  // namespace decid
