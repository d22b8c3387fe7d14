// Units and quantities that the names of columns have. Not installed.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "recording/recording.hpp"
#include "recording/table/table.hpp"

namespace decid::recording {

/// Returns "V" for "sway (V)" and "sway [V]"; empty without a unit in brackets.
std::string_view unit_behind(std::string_view name);
/// Returns the unit of angles at the end of a name, or else at its start ("mrad_sway"), if any.
std::optional<Unit> unit_in(std::string_view name);
/// Returns the quantity of a column whose name excludes an angle: "a length", "a torque", "in counts". Returns nullptr
/// for all other names, and for a column called just "m".
const char* other_quantity(std::string_view name);
/// The quantities of a force plate. A point of force is an angle or a length by its unit.
inline constexpr char centre_of_pressure[] = "a centre of pressure";
inline constexpr char a_force[] = "a force", a_torque[] = "a torque";
/// Returns the unit of a column of angles: the given one, else the name's, if any. Throws Error for a name that
/// excludes an angle ("COM_x (mm)", "sway_deg_s", "tilt speed"), and for a unit with a factor ("sway [1/10 deg]").
/// `where` names the file, `setting_name` the setting of units: "--unit".
std::optional<Unit> find_unit(const std::string& name, std::optional<Unit> given, const std::string& where,
                              const std::string& setting_name);
/// Returns the unit of a table's column: the given one, else the name's, else the file's own, else degrees with a note.
/// Warns if a given unit differs from the name's, or if the name excludes an angle. Throws Error as find_unit().
Unit angle_unit(const Table& table, int column, std::optional<Unit> given, const std::string& setting_name,
                Recording& recording);
/// Returns the metres of the unit of length at the end of a name, if any; nothing for a unit with a factor.
std::optional<double> find_metres_per_unit(std::string_view name);
/// Returns one unit in radians.
double rad_in(Unit unit);
/// Returns "com_x" for "COM_x (deg)".
std::string name_without_unit(std::string_view name);
/// Returns "COM x" for "COM x (deg)" and "COM x [mm]".
std::string name_before_unit(std::string_view name);

}  // namespace decid::recording
