// Headers behind # or %, as NumPy, MATLAB and ROS write them: "# time,COM_x_cm". Not installed.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "recording/stated_rate.hpp"

namespace decid::recording {

/// Returns the names of the columns in the comments just above a table, with the units of a line below them: the last
/// comment of as many cells of which one names a time, a unit, a part of the body or the like, so that remarks are
/// none. Empty if there is none. `above`: the text up to the first row.
std::vector<std::string> commented_names(std::string_view above, char separator, std::size_t columns);

/// Returns true for a name that tells what a column is: a time, a unit, another quantity, sway, tilt, an angle.
bool is_known_name(std::string_view cell);

/// Adds the sample rates that the comments state.
void add_commented_rates(std::string_view above, std::vector<StatedRate>& rates);

}  // namespace decid::recording
