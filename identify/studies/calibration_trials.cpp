// The trials of a calibration: see calibration_trials.hpp.
#include "identify/studies/calibration_trials.hpp"

#include <chrono>
#include <cmath>

#include "base/error.hpp"
#include "dataset/sets/dataset.hpp"
#include "sim/protocol/conditions.hpp"

namespace decid {

sim::Protocol with_priors(sim::Protocol protocol, const posterior::Priors& priors) {
  if (priors.start_s > 0.0) protocol.conditions[sim::Condition::start] = {.share = 1.0, .high = priors.start_s};
  // A uniform distribution with the prior's standard deviation.
  if (priors.gain > 0.0)
    protocol.conditions[sim::Condition::gain] = {.share = 1.0, .high = std::sqrt(3.0) * priors.gain};
  return protocol;
}

sim::Parameters uniform_deviation(const sim::ParameterTable& ranges) {
  sim::Parameters deviation(ranges.size());
  for (std::size_t p = 0; p < ranges.size(); ++p) deviation[p] = ranges[p].range() / std::sqrt(12.0);
  return deviation;
}

CalibrationTrials::CalibrationTrials(const sim::Protocol& protocol, const posterior::Priors& priors, std::uint64_t seed)
    : simulator_([&] {
        sim::Protocol recorded = with_priors(protocol, priors);
        if (recorded.standing_s == 0.0) recorded.standing_s = priors.standing_s;
        return recorded;
      }()),
      ranges_(protocol.ranges()),
      seed_(seed) {}

CalibrationTrials::Trial CalibrationTrials::next() {
  const sim::Protocol& protocol = simulator_.protocol();
  std::vector<double> sway(static_cast<std::size_t>(protocol.samples()));
  for (int tried = 0; tried < 10'000; ++tried) {
    const std::uint64_t attempt = next_++;
    sim::TrialInput input = dataset::base_trial(ranges_, seed_, attempt);
    for (std::size_t p = 0; p < ranges_.size(); ++p)
      if (ranges_[p].convention) input.parameters[p] = *ranges_[p].convention;
    if (!simulator_.run(input.parameters, input.noise, sway).valid) continue;
    sim::record(protocol, seed_, attempt, sway);
    return {attempt, input.parameters, {sway.begin(), sway.end()}};
  }
  throw Error(Code::body_falls, "protocol " + protocol.name, "10,000 trials in a row fell",
              "use a smaller stimulus or less noise");
}

std::optional<CalibratedTrial> calibrate_trial(const posterior::Density& density, const CalibrationTrials::Trial& trial,
                                               const sim::ParameterTable& ranges, posterior::Settings settings,
                                               const std::function<bool()>& stop) {
  const auto begin = std::chrono::steady_clock::now();
  settings.seed = trial.attempt;
  const posterior::Posterior found = posterior::sample(density, density.observe(trial.sway_rad), settings, {},
                                                       [&](const posterior::Progress&) { return !stop(); });
  if (stop()) return std::nullopt;
  CalibratedTrial result = calibrate(trial.truth, found, ranges);
  result.attempt = trial.attempt;
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return result;
}

NetworkAnswers::NetworkAnswers(const Model& model, const sim::Protocol& protocol) {
  if (model.protocol.experiment != protocol.experiment) return;
  identifier_.emplace(model);
  sha256_ = nn::weights_sha256(model.network);
}

void NetworkAnswers::answer(const std::vector<float>& sway_rad, CalibratedTrial& trial) {
  if (!identifier_) return;
  const Estimate found = std::move(identifier_->estimate({recording::trial_of(sway_rad)}).front());
  trial.network = found.parameters;
  if (found.distribution)
    trial.network_log_score = found.distribution->log_density(trial.truth) / static_cast<double>(trial.truth.size());
}

}  // namespace decid
