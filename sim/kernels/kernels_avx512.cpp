// The simulator's kernels for x86-64 with AVX-512.
#include "sim/kernels/generic.hpp"

namespace decid::sim {

const SimulatorKernels& SimulatorTables::avx512() {
  return kernel_table<Native, 2>;
}

}  // namespace decid::sim
