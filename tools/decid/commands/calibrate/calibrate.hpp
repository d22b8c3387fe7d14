// The options of decid calibrate, and parts of its output: the calibration by trials and the tables of conditions share
// them.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/files/json_object.hpp"
#include "identify/result.hpp"
#include "posterior/density/priors.hpp"
#include "posterior/posterior.hpp"
#include "sim/protocol/protocol.hpp"
#include "tools/decid/command.hpp"

namespace decid::tools {

struct CalibrateOptions {
  CommonOptions common;
  ProtocolOptions protocol;
  int trials = 300;
  std::uint64_t seed = 2026;
  bool resume = false, faults = false;
  std::string output, figure, model, conditions;
  std::vector<std::string> with, only;
  posterior::Priors priors{.start_s = 0.0, .gain = 0.0};
  posterior::Settings settings;
};

/// Returns the settings that all trials of one calibration share.
Json settings_json(const CalibrateOptions& options, std::span<const sim::Protocol> protocols);

/// Returns "-" for a number that is not known.
std::string known_number(double value, int digits);

/// Returns "resuming: faults.json has 3 of 18 rows", also if the file does not exist yet.
std::string resuming_text(const std::string& path, std::size_t done, std::size_t all, const char* what);

/// Returns the text of a JSON file that begins with the call.
std::string with_call(Json json, const Call& call);

/// Makes the table of recording conditions or artefacts: fits as users run them, with start and gain unknown. Throws
/// Error for several ranks and for names of --only without a row.
void run_conditions(const CalibrateOptions& options, const Command& command);

}  // namespace decid::tools
