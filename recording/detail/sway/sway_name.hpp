// Conclusions from the name of a column of sway: another angle, a part of the body, another direction, a position. Not
// installed.
#pragma once

#include <string>
#include <string_view>

#include "recording/recording.hpp"

namespace decid::recording {

/// Returns true for the name of an ankle angle.
bool is_ankle_name(std::string_view name);
/// Returns true for a name of sway, of the centre of mass or of a part of the body.
bool is_body_name(std::string_view name);

/// Throws Error for the name of an ankle angle, which is relative to the platform, not in space.
void refuse_ankle(const std::string& name, const std::string& where);

/// Warns of a name of a body part or another direction: the model sways as a whole, about the ankles, in one direction.
void warn_of_part(const std::string& name, Recording& recording);

/// Returns true for "COM_x", "C7 X", "com_position", "COM displacement"; for a bare place, "CoM", "L5", "marker1",
/// "AP"; and for distances, "excursion", "sway rod", "string_pot". Returns false for "sway_x" and "Trunk Angle X".
bool is_position_name(const std::string& name);

/// Returns the axis at the end of a name, apart from units: 'x' for "HIP_X (mm)", "hip.x" and "Hip X"; 0: none.
char axis_of(const std::string& name);

}  // namespace decid::recording
