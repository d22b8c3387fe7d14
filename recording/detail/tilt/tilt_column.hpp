// Finds the platform's tilt among columns without its name. Not installed.
#pragma once

#include "recording/recording.hpp"
#include "recording/trial.hpp"

namespace decid::recording {

/// Compares recording.other_columns with the protocol's tilt, and empties them. A column that moves as sharply as the
/// tilt becomes the recording's tilt, with an info, unless its name is of the body or its sign is the other one: then a
/// caution names it, or an info if it is commanded by its name or has no unit. Among several, decid prefers one of the
/// protocol's size, then one that is measured by its name, and takes a commanded one last. A column without a unit may
/// be a command in volts: decid scales it to the protocol's size, and takes only the start from it. If no column is the
/// tilt, recording.tilt_problem becomes a caution.
///
/// A body follows the tilt too: the correlation of a noise-free sway with a ternary sequence is 0.997 in the median.
/// But its velocity answers each state of the sequence for longer than the state lasts. So decid looks at the
/// cross-correlation of the velocities: one state beside its peak it must be below 0.1 of the peak. Protocols without
/// a sequence have no states, and no column is looked for.
void look_for_tilt_by_values(const ProtocolPlan& plan, double from_hz, Recording& recording);

}  // namespace decid::recording
