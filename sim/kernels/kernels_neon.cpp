// The simulator's kernels for AArch64.
#include "sim/kernels/generic.hpp"

namespace decid::sim {

const SimulatorKernels& SimulatorTables::neon() {
  return kernel_table<Native, 2>;
}

}  // namespace decid::sim
