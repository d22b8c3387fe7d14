// Finds the columns that may be the sway if no column has its name. Not installed.
#pragma once

#include <vector>

#include "recording/table/table.hpp"

namespace decid::recording {

/// Returns all columns except the time (-1: the table has none), row counters, events, quaternions and columns whose
/// names exclude an angle (forces, centres of pressure, velocities). If none remains, returns the columns of such
/// names; without these, the quaternions; without these, all columns except the time.
std::vector<int> sway_candidates(const Table& table, int time);

}  // namespace decid::recording
