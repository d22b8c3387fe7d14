// Samples on an even grid: interpolated from those of an uneven clock, and gaps that are filled on request.
// Not installed.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "base/sample_range.hpp"
#include "recording/detail/clock.hpp"

namespace decid::recording {

/// Returns the values on the clock's even grid. Interpolates by cubics between four neighbours, and linearly next to
/// gaps and between very close neighbours, where a cubic would swing with their noise. Returns NaN where a neighbour is
/// missing or neighbours are farther apart than the clock's gap. Does not move times that are 1% of a sample off.
std::vector<double> place_evenly(const std::vector<double>& values, const Clock& clock);

/// Fills runs of NaN up to `longest_s`: linearly between their neighbours, at an end with the nearest value. A curve
/// through neighbours would swing with the measurement noise. Throws Error for a longer run, with `place_of(first)`,
/// its start, `name`, the number of runs and the longest, and if all values are missing. Adds the filled samples to
/// `gaps`. Returns the text of a warning, empty if nothing was filled.
std::string fill_gaps(std::vector<double>& values, double rate_hz, double longest_s, const std::string& name,
                      const std::string& where, const std::function<std::string(std::size_t first)>& place_of,
                      std::vector<SampleRange>& gaps);

}  // namespace decid::recording
