// Finds jumps of the sway that a body cannot make: occluded markers written as 0, another sensor's samples, stretches
// that were joined. Not installed.
#pragma once

#include <span>

#include "base/warning.hpp"

namespace decid::recording {

/// Adds `jumps`, a caution, if lines through the samples before and after some place miss each other by more than 0.1
/// degrees, twelve times their median and three steps of a coarse sensor. Ignores single wrong samples, and the end of
/// a stretch in which the sensor froze. `step_rad`: the step of a coarse sensor, or 0. `begin_s`: as in quality.hpp.
void look_for_jumps(std::span<const double> sway_rad, double rate_hz, double step_rad, double begin_s,
                    Warnings& warnings);

}  // namespace decid::recording
