// Finds the columns that may be the sway if no column has its name. Not installed.
#pragma once

#include <vector>

#include "recording/table/table.hpp"

namespace decid::recording {

/// Returns all columns except the time (-1: the table has none), row counters, events, texts, quaternions and columns
/// whose names exclude an angle (forces, centres of pressure, velocities). If none remains, returns the columns of such
/// names; without these, the quaternions; without these, all columns except the time.
std::vector<int> sway_candidates(const Table& table, int time);

/// Returns the columns whose names have a unit of lengths, except centres of pressure.
std::vector<int> length_candidates(const Table& table, int time);

/// Returns those of the columns that are called centre of mass, forward or in no direction: "COM_x_mm",
/// "CentreOfMass X (mm)", "Sub1:COM_X_mm", "KSP_x_mm". Several are of several people or languages.
std::vector<int> centre_of_mass_columns(const Table& table, const std::vector<int>& columns);

}  // namespace decid::recording
