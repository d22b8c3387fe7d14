// Identification of recordings: from files to parameters, and how well these explain what was recorded.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "dataset/recording.hpp"
#include "tools/identification.hpp"
#include "tools/model.hpp"

namespace decid::tools {

struct IdentifyOptions {
  dataset::RecordingOptions recording;
  dataset::TrialOptions trial;
  std::optional<sim::Parameters> truth;
};

/// Reads, identifies and re-simulates each recording. One that cannot be used has an `error` and costs the others
/// nothing.
std::vector<Identification> identify(Model& model, const std::vector<std::filesystem::path>& files,
                                     const IdentifyOptions& options);

/// {"recordings": [...]}: what scripts read.
std::string identifications_json(const std::string& model, const std::vector<Identification>& all);
/// What people read: a table a recording.
std::string identifications_text(const std::vector<Identification>& all);

}  // namespace decid::tools
