// The source of a recording's sway: a column of angles, a column of displacements at a known height, the angles of leg
// and trunk, or markers at hip and shoulder. Not installed.
//   displacement x at the height h above the ankles:  sway = asin(x / h)
//   leg and trunk in space, p1 and p2:                sway = the centre of mass of sim/double_pendulum.hpp
//   markers:  p1 = asin((hip - ankle) / l_L),  p2 = asin((shoulder - hip) / l_T),  lengths of sim/segments.hpp
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "recording/recording.hpp"
#include "recording/table/table.hpp"

namespace decid::recording {

/// The columns that form the sway; the first one sets the number of samples.
struct SwaySource {
  enum class Kind { angle, displacement, segments, markers } kind = Kind::angle;
  std::vector<int> columns;
};

/// Finds the columns. Throws Error for contradicting options, missing columns, columns of different length, a table of
/// frequency responses, and an ankle angle ("ankle_angle": relative to the platform, not in space). `time`: the time
/// column, or -1.
SwaySource find_sway_source(const Table& table, int time, const RecordingOptions& options, Recording& recording);

/// Returns the sway in radians, named after its columns. `read`: returns the numbers of a column, evenly spaced,
/// without gaps. Throws Error for displacements beyond their height, and for ambiguous units.
Signal<double> read_sway(const Table& table, const SwaySource& source, const RecordingOptions& options,
                         const std::function<std::vector<double>(int column)>& read, Recording& recording);

}  // namespace decid::recording
