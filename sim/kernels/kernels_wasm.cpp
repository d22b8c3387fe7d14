// The simulator's kernels for WebAssembly's vectors.
#include "sim/kernels/generic.hpp"

namespace decid::sim {

const SimulatorKernels& SimulatorTables::wasm() {
  return kernel_table<Native, 2>;
}

}  // namespace decid::sim
