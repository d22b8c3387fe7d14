// Recordings on their way, whoever identifies them: read and brought to a protocol, and, once their parameters are
// known, compared with trials simulated from these.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "dataset/recording/trial.hpp"
#include "identify/identification.hpp"
#include "sim/simulate.hpp"

namespace decid {

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

}  // namespace decid
