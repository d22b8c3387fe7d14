// The source of a recording's sway: a column of angles, a column of displacements at a known height, the angles of leg
// and trunk, or markers at hip and shoulder. Not installed.
#pragma once

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
/// frequency responses, a centre of mass above the person's head, and an ankle angle ("ankle_angle": relative to the
/// platform, not in space). `time`: the time column, or -1. `axis`: the sway's column if it is
/// known, or -1.
SwaySource find_sway_source(const Table& table, int time, const RecordingOptions& options, Recording& recording,
                            int axis = -1);

}  // namespace decid::recording
