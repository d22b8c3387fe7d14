// The simulator's kernels for AArch64.
#include "sim/kernels/generic.hpp"

namespace decid::sim {

const SimulatorKernels& neon_simulator_kernels() {
  return kernel_table<Native, 2>;
}

}  // namespace decid::sim
