// Trials as a data set draws them, and what a step of one costs.
#pragma once

#include <cstdint>

#include "dataset/sets/dataset.hpp"

namespace decid::bench {

/// 24 operations, 12 of them fused multiply-adds, which count twice.
inline constexpr double flops_per_step = 36;

/// Trial `index` of seed 1.
inline sim::TrialInput make_trial(int index, bool noise = true) {
  sim::TrialInput trial = dataset::base_trial(sim::single_pendulum().parameters, 1, static_cast<std::uint64_t>(index));
  if (!noise) trial.parameters[sim::Nv] = 0;
  return trial;
}

}  // namespace decid::bench
