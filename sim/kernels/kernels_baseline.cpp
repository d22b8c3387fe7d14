// The simulator's kernels for x86-64 as every such processor has it (SSE2).
#include "sim/kernels/generic.hpp"

namespace decid::sim {

const SimulatorKernels& SimulatorTables::baseline() {
  return kernel_table<Native, 2>;
}

}  // namespace decid::sim
