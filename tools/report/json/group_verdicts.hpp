// Verdicts of a comparison of groups, in sentences: by the intervals that hold together.
#pragma once

#include <string>
#include <vector>

#include "identify/result.hpp"

namespace decid::tools {

struct GroupVerdicts {
  std::string intervals;               ///< the intervals that decide, for people
  std::vector<std::string> sentences;  ///< one per pair of groups, and per difference of differences
  /// Possible mistakes in the table of groups, if there are sentences: each recording counts as a person, groups of
  /// fewer than two people, groups whose names are marks of exclusion.
  std::vector<std::string> notes = {};
};

/// Returns one sentence per comparison, such as "patients and controls: delay: patients longer, 21 ms [5, 37]; no
/// difference shown in: Kp, Kd". A name that is a number is "group 1", "session 1" or "condition 1". The hierarchical
/// model's simultaneous intervals decide, or without it the adjusted ones. Empty without groups.
GroupVerdicts group_verdicts(const Report& report);

}  // namespace decid::tools
