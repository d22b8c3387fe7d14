// Reads the platform's tilt from a table, or the columns that may be it. Not installed.
#pragma once

#include <functional>
#include <vector>

#include "recording/recording.hpp"
#include "recording/table/table.hpp"

namespace decid::recording {

/// Returns a column's values on the recording's even grid; missing ones are NaN. Throws Error for a cell that is not a
/// number.
using ReadColumn = std::function<std::vector<double>(int column)>;

/// Reads the tilt's column in radians; its size is compared with the protocol's later. Bridges missing values by
/// straight lines, of any length: the tilt shows only start, size and sign. Throws Error if more than half of it is
/// missing, and for a few numbers that are farther than 90 degrees from the others, which stand for missing values.
void read_tilt(const Table& table, int column, int sway, const ReadColumn& read, const RecordingOptions& options,
               Recording& recording);

/// Reads the tilt found by its name. If that column cannot be used, adds a caution; an info if it is no angle by its
/// name, or holds words. Without such a column, reads the numeric columns that may be the tilt to
/// recording.other_columns. `sways`: the columns of the sway.
void look_for_tilt(const Table& table, int time, const std::vector<int>& sways, const ReadColumn& read,
                   const RecordingOptions& options, Recording& recording);

}  // namespace decid::recording
