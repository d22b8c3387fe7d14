// The axis of a centre of mass that has several: the one that follows the platform's tilt. Not installed.
#pragma once

#include <vector>

#include "recording/recording.hpp"
#include "recording/table/table.hpp"
#include "recording/trial.hpp"

namespace decid::recording {

/// Returns the columns whose names differ from the sway's only by the axis, "COM_y_mm" beside "COM_x_mm". `time`: the
/// time column, or -1.
std::vector<int> axes_beside(const Table& table, int sway, int time);

/// Returns true if a column that read_recording refuses may be a measured axis all the same: neither words nor a
/// constant nor empty.
bool may_be_axis(const Table& table, int column);

/// Brings the axes to the protocol, and returns the one that follows the protocol's tilt; it becomes the recording's
/// sway, with an info that names the others. Empties recording.other_axes and axis_problem. Keeps the first axis with
/// the caution `axis_assumed` if none clearly follows the tilt, and in trials under 40 s. Adds the caution
/// `axes_turned` if another axis follows the tilt a fifth as far, which a turn by 11 degrees does. Throws Error as
/// bring_to_protocol.
Trial bring_axis(const ProtocolPlan& plan, const TrialOptions& options, Recording& recording);

}  // namespace decid::recording
