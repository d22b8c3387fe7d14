// Notes on the groups of a comparison: what may be a mistake in the table of groups.
#pragma once

#include <string>
#include <vector>

#include "identify/result.hpp"

namespace decid::tools {

/// Returns notes for people, beside the verdicts: that each recording counts as a person; groups of fewer than two
/// people, with the group whose name they may misspell; groups whose names are marks of exclusion. Empty without
/// groups.
std::vector<std::string> group_notes(const Report& report);

}  // namespace decid::tools
