// A Report (identify/result.hpp) as JSON for scripts: what the program writes, and what the C interface returns.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/files/json.hpp"
#include "identify/result.hpp"
#include "sim/segments.hpp"

namespace decid::tools {

/// Returns {"decid": version, "model": ..., "model_sha256": ..., "options": [...], "protocol": {...}, "body": ...,
/// "other_answer": ..., "recordings": [...]}, and what groups_json() has. With a distribution each parameter also has
/// "sd", "interval50", "interval90" and "normalized_interval90", each recording "correlations"; of a fit each parameter
/// also "prior" where that is normal, each recording "sensor_noise_deg", "slow_noise_deg", "start_s", "gain",
/// "diagnostics" and more.
std::string report_json(const Report& report);
/// Returns the list of recordings in it.
Json recordings_json(const Report& report);
Json body_json(const sim::Body& body, bool assumed);
/// Returns the weight and height of a person with this body, or nothing if no person has it.
std::optional<sim::Participant> find_participant(const sim::Body& body);

/// Returns the SHA-256 of a file, which may be larger than the memory. Throws Error if it cannot be read.
std::string hash_file(const std::string& path);
/// Returns files and the files beside them that belong to them, such as the sidecars of BIDS, each once, with their
/// SHA-256. Empty names do not count.
std::vector<InputFile> hash_inputs(const std::vector<std::string>& files);

}  // namespace decid::tools
