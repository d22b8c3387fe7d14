// The simulator's kernels, written once on a vector type and compiled once per instruction set.
#pragma once

#include "sim/kernels/generic_fft.hpp"
#include "sim/kernels/generic_pendulums.hpp"
#include "sim/kernels/kernels.hpp"

namespace decid::sim {
namespace {

/// vectors: the number of registers of trials that advance alternately.
template <class V, int vectors>
constexpr SimulatorKernels kernel_table{advance_pendulums<V, vectors>, fft_kernels<V, 8>};

}  // namespace
}  // namespace decid::sim
