// The simulator's kernels for x86-64 with AVX2 and FMA (2013 on).
#include "sim/kernels/generic.hpp"

namespace decid::sim {

const SimulatorKernels& SimulatorTables::avx2() {
  return kernel_table<Native, 2>;
}

}  // namespace decid::sim
