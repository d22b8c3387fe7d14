// Sample times: even and uneven time columns, lost samples, and gaps that are filled on request.
// Not installed.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/sample_range.hpp"
#include "recording/table/table.hpp"

namespace decid::recording {

/// Places of a recording's samples on an even grid of rate_hz; the first is at 0.
struct Clock {
  double rate_hz = 0.0;
  std::vector<double> place;      ///< in samples, strictly increasing; empty: sample k at k
  std::string warning;            ///< the text of a warning, if times were uneven
  bool is_caution = false;        ///< the warning's severity
  bool has_shared_times = false;  ///< several samples have the same time
  std::string first_uneven;  ///< the first step that is not even: "line 4: 'time' steps by 0.02, elsewhere by 0.01"
  double first_s = 0.0;      ///< the first sample's time
  double gap = 1.5;          ///< in samples: neighbours farther apart enclose a gap
};

/// Returns the sample rate and the sample places of a time column, in seconds unless its name says otherwise.
/// - Times are even if all steps lie within 1% of their median, or if they are an even grid rounded to 1 ms or 0.1 ms.
/// - Otherwise each step may differ by 30% of the median from a whole multiple of it. Multiples beyond 1 are lost
/// samples.
/// - Times of an even grid may be rounded so coarsely that samples share them. The clock then has a warning.
/// - If a tenth of the steps or more are uneven (headsets, webcams), steps may have any length. The rate is that of the
/// mean step, and a step of more than 2.5 median steps is a gap.
/// Throws Error if the times start again, and for the first step that does not fit, or among uneven steps the first
/// that goes backwards. The error names `setting_name`
/// ("--rate"), which gives the rate instead.
Clock read_clock(const Table& table, int column, const std::string& where, const std::string& setting_name);

/// Returns the rows at which the times start again, as in a file of several recordings. Returns none if the times never
/// start again or cannot be read. A single wrong time is not a start.
std::vector<std::size_t> restarts(const Table& table, int column);

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
