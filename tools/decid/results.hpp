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
/// lines about a recording's table.
Json recording_json(const Identification& id, const sim::Protocol& protocol);
Json body_json(const sim::Body& body, bool assumed);
std::string recordings_json(const std::string& model, const Identifications& all, const Json& recordings);
/// The recording, and what its answer is worth.
std::string headline(const Identification& id);
/// How it sways, and how much of that its answer explains.
std::string sway_text(const Identification& id);
/// A line: usable, with caution, or not, with the gravest of the warnings; and a line for each of the others.
std::string trust_text(const Warnings& warnings);
std::string warnings_text(const Warnings& warnings);
/// Whose stiffness and damping the tables show: a line below them.
std::string body_text(const Identifications& all);

}  // namespace decid::tools
