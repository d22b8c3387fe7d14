// Sample times: even and uneven time columns, and lost samples. Not installed.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "recording/table/table.hpp"

namespace decid::recording {

/// In median steps. Steps within `even_step` are even. No clock makes a step that differs by more than `gross_step`
/// from every whole number of median steps.
inline constexpr double even_step = 0.01, gross_step = 0.3;

/// Places of a recording's samples on an even grid of rate_hz; the first is at 0.
struct Clock {
  double rate_hz = 0.0;
  double unit_s = 1.0;            ///< of the time column
  std::vector<double> place;      ///< in samples, strictly increasing; empty: sample k at k
  std::string warning;            ///< the text of a warning, if times were uneven
  bool is_caution = false;        ///< the warning's severity
  bool has_shared_times = false;  ///< several samples have the same time
  std::string first_uneven;  ///< the first step that is not even: "line 4: 'time' steps by 0.02, elsewhere by 0.01"
  double first_s = 0.0;      ///< the first sample's time
  double gap = 1.5;          ///< in samples: neighbours farther apart enclose a gap
};

/// Returns the sample rate and the sample places of a time column, in seconds unless its name says otherwise, or its
/// first time does: 1e12 to 4e12, 1e15 to 4e15 and 1e18 to 4e18 are Unix times (2001 to 2096) in milliseconds,
/// microseconds and nanoseconds.
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

}  // namespace decid::recording
