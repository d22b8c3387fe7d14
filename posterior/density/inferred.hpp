// What a posterior's draws say of signals that nobody recorded: the vestibular noise, the estimate of the platform's
// tilt, the sway as the model has it with that noise; and how well they predict a block of the recording from the rest.
#pragma once

#include <vector>

#include "posterior/posterior.hpp"
#include "posterior/sampling/leave_one_out.hpp"

namespace decid::posterior {

/// 5, 50 and 95 % of the draws are below these, at each time.
struct Band {
  std::vector<double> low, middle, high;
};

/// values: those of all times, a draw after the other. Throws Error unless they are a multiple of `times`, and some.
Band band_of(std::span<const double> values, int times);

struct Inferred {
  Band sway_rad;           ///< in blocks of the density, as the recording has it: from its start, with its gain
  Band noise_rad_s;        ///< velocity of the vestibular noise at the dead band, at the edges of the density's bins
  Band tilt_estimate_rad;  ///< what passes the dead band, integrated; likewise
  /// Of the means of blocks, in degrees: each given the parameters, the noise and the blocks before.
  LeaveOneOut left_out;
};

/// From the points that `found` keeps whole. Throws Error if they are fewer than leave_one_out() needs, or of another
/// density.
Inferred infer(const Density& density, const Observation& observation, const Posterior& found);

}  // namespace decid::posterior
