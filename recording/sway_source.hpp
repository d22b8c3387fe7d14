// Where a recording's sway comes from: a column of angles, one of displacements at a known height, the angles of leg
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

/// The columns that the sway is made of, the one whose samples count first.
struct SwaySource {
  enum class Kind { angle, displacement, segments, markers } kind = Kind::angle;
  std::vector<int> columns;
};

/// Which columns they are. Throws Error for options that contradict each other, columns that there are not, an angle of
/// the ankle ("ankle_angle": it is the body's against the platform, not in space), a table of frequency responses, and
/// columns of different length. `time`: the column of time, or -1.
SwaySource find_sway_source(const Table& table, int time, const RecordingOptions& options, Recording& recording);

/// The sway in radians, its name that of the columns. `read`: the numbers of a column, evenly spaced, without gaps.
/// Throws Error for displacements beyond their height, and units that are not clear.
Signal<double> read_sway(const Table& table, const SwaySource& source, const RecordingOptions& options,
                         const std::function<std::vector<double>(int column)>& read, Recording& recording);

}  // namespace decid::recording
