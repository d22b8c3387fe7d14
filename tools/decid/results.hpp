// What `decid identify` reports on recordings: as JSON for scripts, as text for people.
#pragma once

#include <string>
#include <vector>

#include "base/json.hpp"
#include "identify/recordings.hpp"

namespace decid::tools {

/// {"model": ..., "body": ..., "recordings": [...]}: what scripts read. Of a model that gives distributions each
/// parameter also has "sd", "interval50", "interval90" and "normalized_interval90", each recording "correlations".
std::string identifications_json(const std::string& model, const Identifications& all);
/// What people read: a table for each recording.
std::string identifications_text(const Identifications& all);

/// Their parts, for commands that have more to report: a recording's object, the document of such objects, and the
/// lines above a recording's table.
Json recording_json(const Identification& id, const sim::Protocol& protocol);
std::string recordings_json(const std::string& model, const Identifications& all, const Json& recordings);
std::string headline(const Identification& id);
/// Whose stiffness and damping the tables show: a line below them.
std::string body_text(const Identifications& all);

}  // namespace decid::tools
