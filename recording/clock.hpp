// When samples were taken: even and uneven columns of time, lost samples, and gaps that are filled on request.
// Not installed.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "recording/table/table.hpp"

namespace decid::recording {

/// Where the samples of a recording lie on an even grid of rate_hz, the first at 0.
struct Clock {
  double rate_hz = 0.0;
  std::vector<double> place;  ///< in samples, strictly increasing; empty: sample k at k
  std::string warning;        ///< for people, if times were uneven
  bool is_caution = false;    ///< the warning's severity
  std::string first_uneven;   ///< the first step that is not even: "line 4: 'time' steps by 0.02, elsewhere by 0.01"
  double gap = 1.5;           ///< in samples: neighbours farther apart have a gap between them
};

/// Sample rate and places of a column of time, in seconds unless its name says otherwise. Steps within 1% of their
/// median, and times that are an even grid rounded to 1 ms or 0.1 ms, are even. Else each step may differ by 30% of the
/// median from a whole multiple of it; multiples beyond 1 are lost samples. Times of an even grid may be rounded so
/// coarsely that samples share them; the clock then has a warning. Where a tenth of the steps or more are uneven, as
/// headsets and webcams time their frames, steps may have any length: the rate is that of the mean step, and a step of
/// more than 2.5 median steps is a gap. Throws Error if the times start again, and for the first step that does not
/// fit; the error names `setting` ("--rate"), which gives the rate instead.
Clock read_clock(const Table& table, int column, const std::string& where, const std::string& setting);

/// The rows at which the times start again, as those of recordings below each other do; none if they never do, or
/// cannot be read. A single wrong time is no start.
std::vector<std::size_t> restarts(const Table& table, int column);

/// Values at the clock's places brought to its even grid: by cubic interpolation between four neighbours, linear beside
/// gaps and where neighbours are so close that a cubic would swing with their noise. NaN where the neighbours are
/// farther apart than the clock's gap or missing. Times that are 1% of a sample off are not moved.
std::vector<double> place_evenly(const std::vector<double>& values, const Clock& clock);

/// Runs of NaN up to `longest_s` are filled: linearly between their neighbours, at an end with the nearest value (a
/// curve through neighbours would swing with the sensor's noise). Throws Error for a longer run, saying when it begins,
/// for `name`, and if all values are missing. Returns a warning, empty if there was nothing to fill.
std::string fill_gaps(std::vector<double>& values, double rate_hz, double longest_s, const std::string& name,
                      const std::string& where);

}  // namespace decid::recording
