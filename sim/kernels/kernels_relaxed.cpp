// The simulator's kernels for WebAssembly's relaxed vectors.
#include "sim/kernels/generic.hpp"

namespace decid::sim {

const SimulatorKernels& SimulatorTables::relaxed() {
  return kernel_table<Native, 2>;
}

}  // namespace decid::sim
