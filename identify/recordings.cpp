// Recordings, read and explained: see recordings.hpp.
#include "identify/recordings.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "identify/following.hpp"
#include "identify/frequency_response.hpp"

namespace decid {
namespace {

struct Fit {
  double rms_residual_deg, variance_accounted_for;
};

/// How much of `sway` the trial `fitted` explains, means removed. NaN if it fell over before its end.
Fit compare(std::span<const float> sway, std::span<const float> fitted) {
  if (fitted.size() < sway.size()) return {std::nan(""), std::nan("")};
  const double sway_mean = mean(sway), fitted_mean = mean(fitted);
  double residual = 0, variance = 0;
  for (std::size_t k = 0; k < sway.size(); ++k) {
    const double centred = static_cast<double>(sway[k]) - sway_mean;
    const double difference = centred - (static_cast<double>(fitted[k]) - fitted_mean);
    residual += difference * difference;
    variance += centred * centred;
  }
  return {std::sqrt(residual / static_cast<double>(sway.size())) / sim::rad_per_deg, 1 - residual / variance};
}

/// A trial of these parameters as far as it stands: first without vestibular noise, then some with it.
std::vector<std::vector<float>> resimulate(const sim::Simulator& simulator, const sim::Parameters& parameters,
                                           int noisy) {
  const sim::Parameters with_noise = simulable(parameters);
  sim::Parameters without = with_noise;
  without[sim::Nv] = 0.0;
  std::vector<std::vector<float>> trials(static_cast<std::size_t>(1 + noisy));
  simulator.run_all(
      1 + noisy,
      [&](int i) {
        return sim::Trial{i == 0 ? without : with_noise,
                          Random(0, Stream::vestibular_noise, static_cast<std::uint64_t>(std::max(i - 1, 0)))};
      },
      [&](int i, const sim::Outcome& outcome, std::span<double> sway) {
        const auto stands = static_cast<std::size_t>(outcome.end_s * simulator.protocol().sample_rate_hz);
        if (!outcome.valid) sway = sway.first(std::min(stands, sway.size()));
        trials[static_cast<std::size_t>(i)].assign(sway.begin(), sway.end());
      });
  return trials;
}

/// The fit, and a warning if it is worse than noise explains: the noise-free trial is compared with noisy ones of the
/// same parameters as with the recording.
void compare_with_recording(const sim::Simulator& simulator, Identification& id) {
  constexpr int realisations = 5;
  std::vector<std::vector<float>> trials = resimulate(simulator, id.parameters, realisations);
  id.fitted_rad = std::move(trials.front());
  const Fit found = compare(id.sway_rad, id.fitted_rad);
  id.rms_residual_deg = found.rms_residual_deg;
  id.variance_accounted_for = found.variance_accounted_for;
  if (!std::isfinite(found.variance_accounted_for)) {
    id.warnings.push_back(
        "the identified controller does not stand: simulated, the body falls, so there is no fit to quote");
    return;
  }
  std::vector<double> usual;
  for (std::size_t i = 1; i < trials.size(); ++i) {
    if (trials[i].size() < id.sway_rad.size()) continue;  // one that fell tells nothing of the others
    usual.push_back(compare(trials[i], id.fitted_rad).variance_accounted_for);
  }
  if (usual.empty()) {
    id.warnings.push_back(
        "the identified controller stands without its noise but falls with it: it is near the border "
        "of what stands");
    return;
  }
  const auto [low, high] = std::ranges::minmax(usual);
  if (found.variance_accounted_for < low - (high - low) - 0.1)
    id.warnings.push_back(format(
        "the identified controller, without noise, explains %.0f%% of the recording's variance, where it explains "
        "%.0f to %.0f%% of simulated trials with its noise: the recording may not be of this protocol or of this kind "
        "of controller",
        100 * found.variance_accounted_for, 100 * low, 100 * high));
}

}  // namespace

double mean(std::span<const float> values) {
  double sum = 0;
  for (const float v : values) sum += static_cast<double>(v);
  return sum / static_cast<double>(values.size());
}

std::vector<Identification> read_recordings(const sim::Simulator& simulator,
                                            const std::vector<std::filesystem::path>& files,
                                            const ReadOptions& options) {
  const sim::Protocol& protocol = simulator.protocol();
  std::vector<Identification> all(files.size());
  for (std::size_t i = 0; i < files.size(); ++i) {
    Identification& id = all[i];
    id.file = files[i].string();
    id.protocol = protocol;
    id.truth = options.truth;
    try {
      dataset::Recording recording = dataset::read_recording(files[i], options.recording);
      dataset::Trial trial = dataset::fit_to_protocol(recording, protocol, options.trial);
      id.sway_rad = std::move(trial.sway_rad);
      id.tilt = std::move(trial.tilt);
      id.column = recording.column;
      id.tilt_column = recording.tilt_column;
      id.warnings = std::move(recording.warnings);
    } catch (const Error& error) {
      id.error = error;
      continue;
    }
    const auto [low, high] = std::ranges::minmax(id.sway_rad);
    id.peak_to_peak_deg = static_cast<double>(high - low) / sim::rad_per_deg;
    const int steps_per_sample = protocol.steps_per_sample();
    for (std::size_t s = 0; s < id.sway_rad.size(); ++s)
      id.tilt_rad.push_back(static_cast<float>(simulator.stimulus().tilt_at(static_cast<int>(s) * steps_per_sample)));
  }
  return all;
}

void explain(const sim::Simulator& simulator, Identification& id) {
  compare_with_recording(simulator, id);
  add_frequency_response(id);
  try {
    id.following = Following(simulator).measure(id.parameters, id.sway_rad);
  } catch (const Error&) {  // a length that no transform is planned for: it stays unknown
  }
}

void warn_unless_following(Identification& id) {
  constexpr double least = 0.3;
  if (id.following >= least || std::isnan(id.following)) return;
  id.warnings.push_back(
      format("the sway hardly follows the protocol's tilt: %.2f of the response that the identified controller would "
             "have (8%% of valid simulated trials have less than %g, where noise drowns it); was it this protocol, and "
             "in time with the recording?",
             id.following, least));
}

}  // namespace decid
