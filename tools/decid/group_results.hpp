// Groups of recordings compared, as JSON and text: identify/groups.hpp has the formulas.
#pragma once

#include <string>
#include <vector>

#include "base/json.hpp"
#include "sim/parameters.hpp"

namespace decid::tools {

/// Adds "group" to each recording that is in one, and returns {"groups": [{"name", "recordings", "parameters":
/// [{"name", "mean", "sd"}]}], "comparisons": [{"groups": [a, b], "parameters": [{"name", "difference", "hedges_g",
/// "interval95"}]}]}: every pair, groups in the order of their names. Recordings with an error and those that are not
/// usable do not count. groups: of each recording.
Json groups_json(Json& recordings, const std::vector<std::string>& groups, const sim::ParameterTable& parameters);

/// The same for people; nothing of null.
std::string groups_text(const Json& groups);

/// The same for pages, with "members": the group of each of the recordings that have no error. Null of null.
Json page_groups(const Json& groups, const Json& recordings);

}  // namespace decid::tools
