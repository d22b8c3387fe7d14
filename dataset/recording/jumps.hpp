// Places where sway jumps to another level, as no body does: occluded markers written as 0, samples of another sensor,
// lost stretches joined together. Not installed.
#pragma once

#include <span>

#include "base/warning.hpp"

namespace decid::dataset {

/// Adds `jumps`, a caution, if lines through the samples before and after some place miss each other by more than 0.1
/// degrees, twelve times their median and three steps of a coarse sensor. Single wrong samples are none, nor is the end
/// of a stretch in which the sensor stood still. `step_rad`: of a coarse sensor, else 0.
void look_for_jumps(std::span<const double> sway_rad, double rate_hz, double step_rad, Warnings& warnings);

}  // namespace decid::dataset
