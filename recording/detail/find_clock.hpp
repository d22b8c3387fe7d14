// The clock of a recording: the given rate, its time column's, or the rate that its file states. Not installed.
#pragma once

#include "recording/detail/clock.hpp"
#include "recording/recording.hpp"
#include "recording/table/table.hpp"

namespace decid::recording {

/// Returns the clock of the sway's column; time: its time column, or -1. Drops rows that are copies of the row before
/// them, time included. Adds warnings of the rate and the times to the recording, and advice about the rate. Throws
/// Error for an unknown or impossible rate, times that no clock has, and a file of several recordings.
Clock find_clock(Table& table, int sway, int time, const RecordingOptions& options, Recording& recording);

}  // namespace decid::recording
