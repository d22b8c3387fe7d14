// Finds stretches of a sway that were not measured: a sensor that froze, samples that were bridged by a straight line.
// Not installed.
#pragma once

#include <span>
#include <vector>

#include "base/sample_range.hpp"

namespace decid::recording {

/// Stretches of a sway in which its values tell that they were not measured.
struct Stretches {
  /// One value for 0.1 s and at least 5 samples, and twelve times as long as the median run, weighted by samples (runs
  /// of a coarse sensor are long). Zeros at the start do not count, because simulated bodies start at rest.
  std::vector<SampleRange> frozen;
  /// Samples between measured ones on a straight line with a slope for 0.1 s and at least 5 samples. A line rounded to
  /// the digits of a file counts. Lines at either end do not: no sample was measured behind them. Empty for a sway
  /// whose samples are often straight outside of lines of 1 s: of a coarse sensor, smooth, or interpolated throughout.
  std::vector<SampleRange> straight;
  /// Both, joined; a frozen stretch without its first sample, which was measured. Frozen ones do not count if
  /// elsewhere the sway usually changes by less than ten of its smallest changes: at a turn it stays within a step of
  /// the sensor, or of the file's digits, for as long.
  std::vector<SampleRange> unmeasured;
};

/// Returns the stretches of a sway in any unit; none of a sway of fewer than three samples.
Stretches find_stretches(std::span<const double> sway, double rate_hz);

/// Returns the ranges in ascending order, joined where they touch or overlap.
std::vector<SampleRange> joined(std::vector<SampleRange> ranges);

}  // namespace decid::recording
