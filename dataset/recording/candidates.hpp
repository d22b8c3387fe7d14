// Columns that may be the sway where none is called so. Not installed.
#pragma once

#include <vector>

#include "dataset/recording/table.hpp"

namespace decid::dataset {

/// All columns but the time (-1: there is none), counters of rows, events, quaternions and what is no angle by its name
/// (forces, centres of pressure, velocities). All but the time if nothing else is left.
std::vector<int> sway_candidates(const Table& table, int time);

}  // namespace decid::dataset
