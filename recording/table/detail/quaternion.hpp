// Columns of quaternions, whose parts are no angles. Not installed.
#pragma once

#include <string>
#include <vector>

#include "recording/table/table.hpp"

namespace decid::recording {

/// Returns true for "qx", "Quat_1" and "orientation quaternion w"; false for an angle of one ("quat_pitch_deg") and for
/// "q1", which may be a joint.
bool is_quaternion_name(const std::string& name);

/// Returns the columns of a table that are parts of quaternions, by their names or by their values: four neighbours
/// whose squares add up to 1 in each row. `among`: the columns to look at, ascending.
std::vector<int> quaternion_columns(const Table& table, const std::vector<int>& among);

/// Throws Error for a column that is a part of a quaternion. `where` names the file.
void refuse_quaternion(const Table& table, int column, const std::string& where);

}  // namespace decid::recording
