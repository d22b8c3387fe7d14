// The simulator's kernels of one instruction set, DECID_TARGET: compiled once for each with its flags (decid_kernels in
// cmake/DecidTargets.cmake).
#include "sim/kernels/generic.hpp"

namespace decid::sim {

const SimulatorKernels& SimulatorTables::DECID_TARGET() {
  return kernel_table<Native, 2>;
}

}  // namespace decid::sim
