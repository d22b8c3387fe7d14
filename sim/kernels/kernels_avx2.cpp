// The simulator's kernels for x86-64 with AVX2 and FMA (2013 on).
#include "sim/kernels/generic.hpp"

namespace decid::sim {

const SimulatorKernels& avx2_simulator_kernels() {
  return kernel_table<Native, 2>;
}

}  // namespace decid::sim
