// What `decid fit` reports on recordings, with their posteriors: as JSON, as text, and as arrays of draws.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "base/files/json_object.hpp"
#include "identify/fit_recordings.hpp"

namespace decid::tools {

/// All that a call's outputs hold of one recording, as a journal can keep it: "recording", its object in the JSON (that
/// of `decid identify`, each parameter also with "sd", "interval50", "interval90", "normalized_interval90" and, where
/// its prior is normal, "prior", each recording with "sensor_noise_deg", "slow_noise_deg", "start_s", "gain",
/// "correlations" and "diagnostics"); "text", what people read; and, unless it has an error, "page" (fit_page.hpp) and
/// "draws", its arrays by name. Ranges are the density's. Text that is not UTF-8 is replaced.
Json fit_result(const FittedRecordings& all, std::size_t number, const posterior::Priors& priors);

/// Every draw of each result, as arrays of an .npz file: "parameters" (draws x parameters, SI units),
/// "sensor_noise_deg", "slow_noise_deg", "start_s", "gain", "chain"; several recordings: "1/parameters", "2/parameters"
/// and so on, by their places in `results`, of which those without draws are left out.
void write_draws(const std::filesystem::path& path, std::span<const Json> results);

}  // namespace decid::tools
