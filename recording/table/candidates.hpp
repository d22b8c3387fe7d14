// Finds the columns that may be the sway if no column has its name. Not installed.
#pragma once

#include <vector>

#include "recording/table/table.hpp"

namespace decid::recording {

/// Returns all columns except the time (-1: the table has none), row counters, events, quaternions and columns whose
/// names exclude an angle (forces, centres of pressure, velocities). Returns those of such names if no other remains,
/// and all columns except the time if there are none of these.
std::vector<int> sway_candidates(const Table& table, int time);

}  // namespace decid::recording
