// Reads the platform's tilt from a table, or the columns that may be it. Not installed.
#pragma once

#include <functional>
#include <vector>

#include "recording/recording.hpp"
#include "recording/table/table.hpp"

namespace decid::recording {

/// Returns a column's values on the recording's even grid, each step-th from the first on; missing ones are NaN.
/// Returns none for a step above 1 if the file's rows are no even grid. Throws Error for a cell that is not a number.
/// Owns the table.
using ReadColumn = std::function<std::vector<double>(int column, std::size_t step)>;

/// Reads the tilt's column in radians; its size is compared with the protocol's later. Bridges missing values by
/// straight lines, of any length: the tilt shows only start, size and sign. If more than half of the values are
/// missing, gaps of up to 0.2 s are those of a slower sensor, and count as measured. Throws Error if more than half is
/// missing in longer gaps, and for a few numbers that are farther than 90 degrees from the others, which stand for
/// missing values.
void read_tilt(const Table& table, int column, int sway, const ReadColumn& read, const RecordingOptions& options,
               Recording& recording);

/// Reads the tilt found by its name. If that column cannot be used, adds a caution; an info if it is no angle by its
/// name, or holds words. If several columns have one name of the tilt, reads the first of equal ones. Without such
/// a column, or if they differ, adds the columns that may be the tilt to recording.other_columns. `sways`: the columns
/// of the sway.
void look_for_tilt(const Table& table, int time, const std::vector<int>& sways, const ReadColumn& read,
                   const RecordingOptions& options, Recording& recording);

}  // namespace decid::recording
