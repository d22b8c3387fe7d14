// Finds when a platform that stood still for long moved, by its measured tilt. Not installed.
#pragma once

#include <span>

#include "base/sample_range.hpp"

namespace decid::recording {

/// Returns the samples between the rests at both ends: those from the first to the last that is farther than a tenth of
/// the tilt's range from its value at that end. Returns no samples for a constant tilt.
SampleRange moving_samples(std::span<const double> tilt);

}  // namespace decid::recording
