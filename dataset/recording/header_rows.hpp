// Headers of several rows, as programs of motion capture, force plates and amplifiers write them. Not installed.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "dataset/recording/stated_rate.hpp"

namespace decid::dataset {

/// The lines above the first row of numbers, the first one first, each with its cells.
using HeaderRows = std::vector<std::vector<std::string_view>>;

/// The names of so many columns from the rows just above the numbers: the lowest that is none of units, with what the
/// rows above say where its names are not unique ("X" of "HIP", "HIP X"), and with the units. Known formats: Motive,
/// Vicon Nexus, Visual3D, Shimmer by that rule; Qualisys (MARKER_NAMES), LabChart (ChannelTitle=), LabVIEW (X_Value),
/// AcqKnowledge. Empty if the lowest row alone will do, or there is none.
std::vector<std::string> names_of_rows(const HeaderRows& rows, std::size_t columns);

/// Adds the rate of Vicon Nexus, a number below the name of its section ("Trajectories").
void add_section_rate(const HeaderRows& rows, std::vector<StatedRate>& rates);

}  // namespace decid::dataset
