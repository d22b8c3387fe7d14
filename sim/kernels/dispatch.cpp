// Selects the simulator's kernels of an instruction set; the plain kernels process one lane at a time.
#include "base/kernels/table_for.hpp"
#include "sim/kernels/generic.hpp"

namespace decid::sim {

const SimulatorKernels& SimulatorTables::reference() {
  return kernel_table<One, 1>;
}

const SimulatorKernels& simulator_kernels(Isa isa) {
  return table_for<SimulatorTables>(isa);
}

}  // namespace decid::sim
