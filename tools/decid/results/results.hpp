// Views of a Report (identify/result.hpp): JSON for scripts, text for people, a table for spreadsheets and R, draws for
// NumPy; tools/report has the pages.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/files/json.hpp"
#include "identify/result.hpp"
#include "sim/segments.hpp"

namespace decid::tools {

/// Options that do not change the answer, and options that the JSON reports elsewhere.
inline const std::vector<std::string> beside_answers{"recordings", "--output", "--draws",      "--report",   "--table",
                                                     "--group",    "--resume", "--threads",    "--quiet",    "--json",
                                                     "--protocol", "--model",  "--controller", "--recursive"};

/// Returns {"decid": version, "model": ..., "model_sha256": ..., "options": [...], "protocol": {...}, "body": ...,
/// "other_answer": ..., "recordings": [...]}, and what groups_json() has. With a distribution each parameter also has
/// "sd", "interval50", "interval90" and "normalized_interval90", each recording "correlations"; of a fit each parameter
/// also "prior" where that is normal, each recording "sensor_noise_deg", "slow_noise_deg", "start_s", "gain",
/// "diagnostics" and more.
std::string report_json(const Report& report);
/// Returns the list of recordings in it.
Json recordings_json(const Report& report);
/// Returns a table for each recording, whose body they are of, and the groups.
std::string report_text(const Report& report);
/// Returns CSV (RFC 4180, lines end in \n), a line a recording: file, trust, each parameter's value and the ends of its
/// 90% interval, and what was wrong with a recording that could not be used, whose other cells are empty. Numbers read
/// back to the same bits.
std::string report_table(const Report& report);
/// Writes every draw of each fit, as arrays of an .npz file: "parameters" (draws x parameters, SI units),
/// "sensor_noise_deg", "slow_noise_deg", "start_s", "gain", "chain"; several recordings: "1/parameters", "2/parameters"
/// and so on, by `places`, the places of the recordings in a call of `count`.
void write_draws(const std::filesystem::path& path, const Report& report, std::span<const std::size_t> places,
                 std::size_t count);

// Parts, for other answers than reports.
Json body_json(const sim::Body& body, bool assumed);
/// Returns a line that says whose stiffness and damping the tables show.
std::string body_text(const sim::Body& body, bool assumed);
/// Returns a line: the trust, with the gravest of the warnings.
std::string trust_text(const Warnings& warnings);
/// Returns a line for each of the other warnings.
std::string warnings_text(const Warnings& warnings);
/// Returns the weight and height of a person with this body, or nothing if no person has it.
std::optional<sim::Subject> person_of(const sim::Body& body);

}  // namespace decid::tools
