// Reads and writes the trials of a calibration as JSON, so that a later call can continue from them.
#pragma once

#include <string>
#include <vector>

#include "base/files/json.hpp"
#include "identify/evaluation/calibration.hpp"

namespace decid::tools {

Json trial_json(const CalibratedTrial& trial);
/// Reads back a trial that has `parameters` parameters. Throws the JSON library's exception if `json` is not a trial.
CalibratedTrial trial_from(const Json& json, std::size_t parameters);

/// Throws Error if a file's settings differ from this call's. The error names the first difference, with both values.
void require_same_settings(const Json& earlier, const Json& now, const std::string& file);

/// Returns the trials that an earlier call wrote to the file, with `parameters` parameters each. Omits the answers of a
/// network other than `network`. Throws Error if the file is not a calibration, or has other settings.
std::vector<CalibratedTrial> earlier_trials(const std::string& file, const Json& settings, const Json& network,
                                            std::size_t parameters);

}  // namespace decid::tools
