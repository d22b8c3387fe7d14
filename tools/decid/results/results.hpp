// What `decid identify` reports on recordings: as JSON for scripts, as text for people.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/files/json.hpp"
#include "identify/recordings.hpp"
#include "tools/report/other_answer.hpp"

namespace decid::tools {

/// What made the answers, so that they can be had again.
struct MadeWith {
  std::string model;                 ///< its name
  std::string weights_sha256;        ///< of its weights
  std::vector<std::string> options;  ///< that were given and change the answers: "--unit rad"
  std::optional<OtherAnswer> other_answer = {};
};

/// Options that change no answer, and those that the JSON has otherwise.
inline const std::vector<std::string> beside_answers{"recordings", "--output", "--draws",    "--report", "--table",
                                                     "--group",    "--resume", "--threads",  "--quiet",  "--json",
                                                     "--protocol", "--model",  "--recursive"};

/// What scripts read of each recording, a list. Of a model that gives distributions each parameter also has "sd",
/// "interval50", "interval90" and "normalized_interval90", each recording "correlations".
Json identifications_list(const Identifications& all);
/// What people read: a table for each recording.
std::string identifications_text(const Identifications& all);
/// The part of one.
std::string identification_text(const Identification& id, const sim::Protocol& protocol);

/// A recording's object.
Json recording_json(const Identification& id, const sim::Protocol& protocol);
Json body_json(const sim::Body& body, bool assumed);
/// {"decid": version, "model": ..., "model_sha256": ..., "options": [...], "protocol": {...}, "body": ...,
/// "other_answer": ..., "recordings": [...]}.
/// groups: as group_results.hpp has them, added if they are not null.
std::string recordings_json(const MadeWith& with, const Identifications& all, const Json& recordings,
                            const Json& groups);

/// Parts of the text, for commands that have more to report: the recording, and what its answer is worth.
std::string headline(const Identification& id);
/// How it sways, and how much of that its answer explains.
std::string sway_text(const Identification& id);
/// A line: usable, with caution, or not, with the gravest of the warnings; and a line for each of the others.
std::string trust_text(const Warnings& warnings);
std::string warnings_text(const Warnings& warnings);
/// Whose stiffness and damping the tables show: a line below them.
std::string body_text(const Identifications& all);
std::string body_text(const sim::Body& body, bool assumed);

}  // namespace decid::tools
