// Recordings on their way through the program, whoever identifies them: read and brought to a protocol, and, once their
// parameters are known, compared with trials simulated from these. `decid identify` and `decid fit` share it.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "dataset/recording.hpp"
#include "sim/simulate.hpp"
#include "tools/command.hpp"
#include "tools/identification.hpp"

namespace decid::tools {

/// How recordings are to be read.
struct ReadOptions {
  dataset::RecordingOptions recording;
  dataset::TrialOptions trial;
  std::optional<sim::Parameters> truth;
};

/// Each file as a trial of the simulator's protocol: everything of an Identification that needs no parameters. One that
/// cannot be used has an `error` and costs the others nothing.
std::vector<Identification> read_recordings(const sim::Simulator& simulator,
                                            const std::vector<std::filesystem::path>& files,
                                            const ReadOptions& options);

/// How well id.parameters explain the recording: the noise-free trial, its residual, the frequency responses, whether
/// it follows the tilt, and a warning if they explain less than noise accounts for.
void explain(const sim::Simulator& simulator, Identification& id);
/// A warning if an explained recording does not follow the tilt, for whoever has nothing better to judge it by.
void warn_unless_following(Identification& id);

double mean(std::span<const float> values);

/// What the commands that read recordings ask for.
struct RecordingFlags {
  std::vector<std::string> files;
  std::string column, unit, truth, tilt_column, tilt_unit, invert, detrend = "none";
  std::optional<double> rate, begin;
  double fill_gaps = 0.0;

  std::vector<std::filesystem::path> paths() const { return {files.begin(), files.end()}; }
  /// Throws Error for what does not go together.
  ReadOptions read_options() const;
};
/// `begin`: the names of the option that says where the protocol starts; messages call it --begin.
void add_recording_flags(CLI::App& command, RecordingFlags& flags, const std::string& begin);

/// One recording alone is all or nothing: throws its error. Of several, the good ones are kept.
void refuse_alone(const std::vector<Identification>& all);
/// When all is written: a line on standard error for each that could not be used, then Error if there is one.
void tell_errors(const std::string& command, const std::vector<Identification>& all);

}  // namespace decid::tools
