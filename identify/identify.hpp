// Identification of recordings: from files to parameters, and how well these explain what was recorded.
#pragma once

#include <filesystem>
#include <vector>

#include "identify/model.hpp"
#include "identify/recordings.hpp"

namespace decid {

/// Reads, identifies and re-simulates each recording. One that cannot be used has an `error` and costs the others
/// nothing.
std::vector<Identification> identify(Model& model, const std::vector<std::filesystem::path>& files,
                                     const ReadOptions& options);

}  // namespace decid
