// What `decid fit` reports on recordings: what `decid identify` does, and their posteriors.
#pragma once

#include <filesystem>
#include <string>

#include "identify/fit_recordings.hpp"

namespace decid::tools {

/// What identify prints; each parameter also has "sd", "interval50", "interval90" and, over m g h,
/// "normalized_interval90", each recording "sensor_noise_deg", "start_s", "gain", "correlations", "diagnostics",
/// "predictive_check" and "log_predictive_density".
std::string fits_json(const std::string& model, const FittedRecordings& all);
std::string fits_text(const FittedRecordings& all);

/// Arrays of every recording's draws: "parameters" (draws x parameters, SI units), "sensor_noise_deg", "start_s",
/// "gain" and "chain", a number for each draw. With several recordings each name begins with the recording's number:
/// "2/gain" is the second one's.
void write_draws(const std::filesystem::path& path, const FittedRecordings& all);

}  // namespace decid::tools
