// What `decid identify` says of recordings: as JSON for scripts, as text for people.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "identify/identification.hpp"

namespace decid::tools {

/// {"model": ..., "recordings": [...]}: what scripts read.
std::string identifications_json(const std::string& model, const std::vector<Identification>& all);
/// What people read: a table a recording.
std::string identifications_text(const std::vector<Identification>& all);

/// Their parts, for commands that have more to say: a recording's object; the document of such objects; what stands
/// above a recording's table.
nlohmann::ordered_json recording_json(const Identification& id);
std::string recordings_json(const std::string& model, const nlohmann::ordered_json& recordings);
std::string headline(const Identification& id);

}  // namespace decid::tools
