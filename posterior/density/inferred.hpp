// Unrecorded signals from a posterior's draws: the vestibular noise, the estimate of the platform's tilt, and the
// modelled sway with that noise. Also the prediction of each block of the recording from the rest.
#pragma once

#include <vector>

#include "posterior/posterior.hpp"
#include "posterior/sampling/leave_one_out.hpp"

namespace decid::posterior {

/// Quantiles at each time: 5, 50 and 95 % of the draws lie below.
struct Band {
  std::vector<double> low, middle, high;
};

/// Returns the quantiles. values: one draw after the other, all times each. Throws Error unless their number is a
/// positive multiple of `times`.
Band make_band(std::span<const double> values, int times);

struct Inferred {
  Band sway_rad;           ///< in blocks of the density, in the recording's frame: its start and its gain
  Band noise_rad_s;        ///< velocity of the vestibular noise at the dead band, at the edges of the density's bins
  Band tilt_estimate_rad;  ///< integral of the passed velocity, at the same edges
  /// For the means of the recorded blocks, in degrees: each given the parameters, the noise and all other blocks.
  LeaveOneOut left_out;
  std::vector<int> recorded_blocks;  ///< the places of those blocks, ascending: all except those that gaps touch
  /// log p(block | draw) of each stored point, its recorded blocks one after the other; empty unless they are kept.
  std::vector<double> log_likelihood;
};

/// Infers from the points that `found` stores completely. Throws Error for fewer points than leave_one_out() needs, or
/// points of another density.
Inferred infer(const Density& density, const Observation& observation, const Posterior& found,
               bool keeps_log_likelihood = false);

}  // namespace decid::posterior
