// Views of a Report (identify/result.hpp): text for people, a table for spreadsheets and R, draws for NumPy;
// tools/report has the JSON and the pages.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "identify/compared_controllers.hpp"
#include "identify/result.hpp"
#include "sim/segments.hpp"
#include "tools/decid/options.hpp"
#include "tools/report/json/report_json.hpp"

namespace decid::tools {

/// Recorded options that the JSON of a report has elsewhere than in its `options`.
inline const std::vector<std::string> options_reported_elsewhere{"--group",      "--protocol", "--model",     "--study",
                                                                 "--controller", "--within",   "--covariates"};
/// Returns the call without its seed. inputs: all files that were read. named: the files that the call gives without an
/// option, which is unrecorded. Empty names do not count.
Call record_call(const Command& command, const std::vector<std::string>& inputs,
                 const std::vector<std::string>& named = {});

/// Returns the summary, a table for each recording, whose body they are of, the groups, and the controllers over all
/// recordings.
std::string report_text(const Report& report);
/// Returns how many of several recordings are usable, how many were fitted together, whether the groups differ, and the
/// best controller. Empty for one recording without groups.
std::string summary_text(const Report& report);
/// Writes every draw of each fit. An .npz file has float64 arrays of chains x draws, each under its name: the
/// parameters in SI units, sensor_noise_deg, slow_noise_deg, start_s, gain, lp, acceptance_rate, diverging, energy; if
/// kept, log_likelihood of chains x stored draws x recorded blocks, with log_likelihood_draw, the places of these draws
/// in their chains, and log_likelihood_block, the places of the blocks in the trial; and parameters of all draws x
/// parameters with chain. Several recordings: "1/Kp", "2/Kp" and so on, by
/// `places`, the places of the recordings in a call of `count`. A .csv file has Stan's columns: .chain, .iteration and
/// .draw from 1, lp__, accept_stat__, divergent__, energy__, then the quantities; with several recordings `file` comes
/// first.
void write_draws(const std::filesystem::path& path, const Report& report, std::span<const std::size_t> places,
                 std::size_t count);

// Parts, for other answers than reports.
/// Returns "Kp, N m/rad", or "Nv" for a plain number. per: what follows the unit, such as " per kg".
std::string name_and_unit(const sim::ParameterInfo& info, const std::string& per = {});
/// Returns a line that says whose stiffness and damping the tables show, and a line if the body is assumed, or if the
/// weight may be in pounds. remedy: for an assumed body.
std::string body_text(const sim::Body& body, bool assumed, const std::string& remedy = "give --mass and --height");
/// Returns a line: the trust, with the most severe of the warnings. what: the checked data, "recording".
std::string trust_text(const Warnings& warnings, const std::string& what = "recording");
/// Returns a line of a warning: its severity, as the JSON names it, and its text.
std::string warning_line(const Warning& warning);
/// Returns a line for each of the other warnings.
std::string warnings_text(const Warnings& warnings);
/// Returns a controller's difference of log densities to the best one, in nats; "best" for the best one.
std::string difference_text(double difference, double standard_error);
/// Returns a table of the controllers over several recordings.
std::string controller_sums_text(const ControllerSums& sums);

}  // namespace decid::tools
