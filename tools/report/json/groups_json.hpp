// Groups compared, as JSON: identify/groups.hpp has the formulas, identify/cohort/cohort.hpp the hierarchical model.
#pragma once

#include "base/files/json.hpp"
#include "identify/result.hpp"

namespace decid::tools {

/// Returns
///   {"groups": [{"name", "participants", "recordings", "parameters": [{"name", "mean", "sd"}]}],
///    "comparisons": [{"groups": [a, b], "paired", "participants": [in a, in b], "unpaired_participants",
///                     "parameters": [{"name", "difference", "interval95", "adjusted_interval95", "hedges_g"}]}],
///    "group_comparison": {"participant_column", "parameters", "pairs", "intervals", "adjustment", "covariates",
///                         "left_out": [{"file", "group", "reason"}], "unused_lines": [{"line", "file"}],
///                         "notes": group_verdicts().notes},
///    "hierarchical": cohort_json(), "reliability": reliability_json()}
/// with every pair that is compared, groups in the order of their names; null of a report without groups.
Json groups_json(const Report& report);

/// Returns the same for pages, with "members": {"group", "left_out"} for each of the recordings that have no error.
Json page_groups(const Report& report);

}  // namespace decid::tools
