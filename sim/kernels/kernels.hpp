// The simulator's kernels, one table an instruction set. All compute the same bits.
#pragma once

#include "base/isa.hpp"
#include "sim/kernels/fft.hpp"
#include "sim/kernels/pendulums.hpp"

namespace decid::sim {

struct SimulatorKernels {
  AdvancePendulums advance_pendulums;
  FftKernels fft;  ///< of fft_lanes signals
};

const SimulatorKernels& simulator_kernels(Isa isa);

// One function an instruction set, in a translation unit of its own.
const SimulatorKernels& reference_simulator_kernels();
const SimulatorKernels& baseline_simulator_kernels();
const SimulatorKernels& avx2_simulator_kernels();
const SimulatorKernels& avx512_simulator_kernels();
const SimulatorKernels& neon_simulator_kernels();

}  // namespace decid::sim
