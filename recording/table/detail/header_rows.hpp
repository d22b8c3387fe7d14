// Reads headers of several rows, which programs for motion capture, force plates and amplifiers write. Not installed.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "recording/detail/stated_rate.hpp"

namespace decid::recording {

/// The lines above the first row of numbers, from top to bottom, split into cells.
using HeaderRows = std::vector<std::vector<std::string_view>>;

/// Returns a name for each column, made from the rows just above the numbers. The lowest row that does not hold units
/// gives the names; while they are not unique, the row above is prefixed ("HIP" and "X": "HIP X"). The units follow;
/// they may also stand directly above the names. A row without a time continues names with one ("CoM" and "AP").
/// This rule reads Motive, Vicon Nexus, Visual3D and Shimmer. Qualisys (MARKER_NAMES), LabChart (ChannelTitle=),
/// LabVIEW (X_Value) and AcqKnowledge have rules of their own. Returns nothing if the lowest row is sufficient, or
/// there is no row.
std::vector<std::string> names_of_rows(const HeaderRows& rows, std::size_t columns);

/// Adds the rate that Vicon Nexus writes below the name of a section ("Trajectories").
void add_section_rate(const HeaderRows& rows, std::vector<StatedRate>& rates);

}  // namespace decid::recording
