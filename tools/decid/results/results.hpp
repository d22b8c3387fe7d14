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
#include "tools/decid/options.hpp"

namespace decid::tools {

/// Options that do not change the answer, and options that the JSON reports elsewhere.
inline const std::vector<std::string> beside_answers{"recordings", "--output",     "--draws",     "--report", "--table",
                                                     "--group",    "--resume",     "--threads",   "--quiet",  "--json",
                                                     "--protocol", "--model",      "--recursive", "--long",   "--excel",
                                                     "--study",    "--controller", "--figures"};
/// Options that no output's content depends on, and the recordings, whose files Report::arguments has.
inline const std::vector<std::string> not_repeated{"recordings", "--output",    "--draws",  "--report",  "--table",
                                                   "--long",     "--excel",     "--resume", "--threads", "--quiet",
                                                   "--json",     "--recursive", "--figures"};
/// Sets the report's command, arguments and inputs. `named`: the recordings' files in the call; `inputs`: all files
/// that were read; empty names do not count.
void record_call(Report& report, const Command& command, const std::vector<std::string>& named,
                 const std::vector<std::string>& inputs);

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
/// Writes every draw of each fit. An .npz file has float64 arrays of chains x draws, each under its name: the
/// parameters in SI units, sensor_noise_deg, slow_noise_deg, start_s, gain, lp, acceptance_rate, diverging, energy; if
/// kept, log_likelihood of chains x stored draws x blocks, with log_likelihood_draw, the places of these draws in their
/// chains; and parameters of all draws x parameters with chain. Several recordings: "1/Kp", "2/Kp" and so on, by
/// `places`, the places of the recordings in a call of `count`. A .csv file has Stan's columns: .chain, .iteration and
/// .draw from 1, lp__, accept_stat__, divergent__, energy__, then the quantities; with several recordings `file` comes
/// first.
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
std::optional<sim::Subject> find_person(const sim::Body& body);

}  // namespace decid::tools
