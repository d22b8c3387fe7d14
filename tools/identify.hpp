// Identification of recordings: from files to parameters, and how well these explain what was recorded.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tools/model.hpp"
#include "tools/recordings.hpp"

namespace decid::tools {

/// Reads, identifies and re-simulates each recording. One that cannot be used has an `error` and costs the others
/// nothing.
std::vector<Identification> identify(Model& model, const std::vector<std::filesystem::path>& files,
                                     const ReadOptions& options);

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
