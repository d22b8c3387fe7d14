// The trials of a calibration in its JSON file, so that a later call can go on from them.
#pragma once

#include <string>
#include <vector>

#include "base/files/json.hpp"
#include "identify/studies/calibration.hpp"

namespace decid::tools {

Json trial_json(const CalibratedTrial& trial);
/// The trial again, of so many parameters. Throws what the JSON library does if it is none.
CalibratedTrial trial_from(const Json& json, std::size_t parameters);

/// Throws Error if a file's settings are not those of this call, and names the first that differs, with both values.
void require_same_settings(const Json& earlier, const Json& now, const std::string& file);

/// The trials that an earlier call wrote to the file, of `parameters` parameters each; without the answers of another
/// network than `network`. Throws Error if it is no calibration, or of other settings.
std::vector<CalibratedTrial> earlier_trials(const std::string& file, const Json& settings, const Json& network,
                                            std::size_t parameters);

}  // namespace decid::tools
