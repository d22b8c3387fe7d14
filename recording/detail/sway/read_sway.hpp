// The sway in radians, from the columns of its source. Not installed.
//   displacement x at the height h above the ankles:  sway = asin(x / h)
//   leg and trunk in space, p1 and p2:                sway = the centre of mass of sim/double_pendulum.hpp
//   markers:  p1 = asin((hip - ankle) / l_L),  p2 = asin((shoulder - hip) / l_T),  lengths of sim/segments.hpp
#pragma once

#include <functional>
#include <vector>

#include "recording/detail/sway/sway_source.hpp"
#include "recording/detail/tilt/read_tilt.hpp"
#include "recording/recording.hpp"
#include "recording/table/table.hpp"

namespace decid::recording {

/// Returns the sway in radians, named after its columns. `read`: returns the numbers of a column, evenly spaced,
/// without gaps. Throws Error for displacements beyond their height, and for ambiguous units.
Signal<double> read_sway(const Table& table, const SwaySource& source, const RecordingOptions& options,
                         const std::function<std::vector<double>(int column)>& read, Recording& recording);

/// Warns if the hip moves by columns that are named leg and trunk beside the sway, a column of angles or displacements.
/// Skips columns that it cannot compare: missing values in more than half of the samples, another length or unit, or
/// a centre of mass that differs from the sway by more than a fifth of it.
void check_hip(const Table& table, int time, const SwaySource& source, const std::vector<double>& sway_rad,
               const RecordingOptions& options, const ReadColumn& read, Recording& recording);

}  // namespace decid::recording
