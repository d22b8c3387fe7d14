// The simulator's kernels of an instruction set, and the plain ones: a lane at a time.
#include "sim/kernels/generic.hpp"

namespace decid::sim {

const SimulatorKernels& reference_simulator_kernels() {
  return kernel_table<One, 1>;
}

const SimulatorKernels& simulator_kernels(Isa isa) {
  switch (isa) {
#if defined(__x86_64__)
    case Isa::baseline:
      return baseline_simulator_kernels();
    case Isa::avx2:
      return avx2_simulator_kernels();
    case Isa::avx512:
      return avx512_simulator_kernels();
#elif defined(__aarch64__)
    case Isa::neon:
      return neon_simulator_kernels();
#endif
    default:
      return reference_simulator_kernels();
  }
}

}  // namespace decid::sim
