// Groups compared, as JSON and text: identify/groups.hpp has the formulas.
#pragma once

#include <string>
#include <vector>

#include "base/files/json.hpp"
#include "sim/parameters.hpp"
#include "tools/decid/group_file.hpp"

namespace decid::tools {

/// Adds "group" to each recording that is in one, and the person under "subject" where the table names people. Returns
///   {"groups": [{"name", "people", "recordings", "parameters": [{"name", "mean", "sd"}]}],
///    "comparisons": [{"groups": [a, b], "paired", "people": [in a, in b], "unpaired_people",
///                     "parameters": [{"name", "difference", "interval95", "adjusted_interval95", "hedges_g"}]}],
///    "group_comparison": {"person_column", "parameters", "pairs", "intervals", "adjustment",
///                         "left_out": [{"file", "group", "reason"}], "unused_lines": [{"line", "file"}]}}
/// with every pair, groups in the order of their names. Leaves out recordings with an error, those that are not usable,
/// and those of a platform that tilted another angle; "reason" is "error", "not usable" or "tilt_of_other_size".
/// table: its members are those of the recordings, in their order.
Json groups_json(Json& recordings, const GroupTable& table, const sim::ParameterTable& parameters);

/// The same for people; nothing of null.
std::string groups_text(const Json& groups);

/// The same for pages, with "members": {"group", "left_out"} for each of the recordings that have no error. Null of
/// null.
Json page_groups(const Json& groups, const Json& recordings);

}  // namespace decid::tools
