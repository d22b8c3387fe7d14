// The simulator's kernels, one table per instruction set. All compute the same bits.
#pragma once

#include "base/isa.hpp"
#include "sim/kernels/fft.hpp"
#include "sim/kernels/pendulums.hpp"

namespace decid::sim {

struct SimulatorKernels {
  AdvancePendulums advance_pendulums;
  FftKernels fft;  ///< for fft_lanes signals
};

const SimulatorKernels& simulator_kernels(Isa isa);

/// Gives table_for access to the tables.
struct SimulatorTables {
  static const SimulatorKernels& reference();
  static const SimulatorKernels& baseline();
  static const SimulatorKernels& avx2();
  static const SimulatorKernels& avx512();
  static const SimulatorKernels& neon();
  static const SimulatorKernels& wasm();
  static const SimulatorKernels& relaxed();
};

}  // namespace decid::sim
