// Headers after # or %, as NumPy, MATLAB and ROS write them: "# time,COM_x_cm". Not installed.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "recording/detail/stated_rate.hpp"
#include "recording/detail/stated_unit.hpp"

namespace decid::recording {

/// Returns the names of the columns in the comments just above a table, with the units of a line below them. The header
/// is the last comment with as many cells as the table has columns, at least one of which names a time, a unit, a part
/// of the body or similar; remarks have no such name. Empty without a header. `above`: the text up to the first row.
std::vector<std::string> commented_names(std::string_view above, char separator, std::size_t columns);

/// Returns true for a name that identifies a column: a time, a unit, another quantity, sway, tilt, an angle.
bool is_known_name(std::string_view cell);

/// Adds the sample rates and the units that the comments state.
void read_comments(std::string_view above, std::vector<StatedRate>& rates, std::vector<StatedUnit>& units);

}  // namespace decid::recording
