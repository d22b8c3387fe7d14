// The trials of a calibration: see calibration_trials.hpp.
#include "identify/evaluation/calibration_trials.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

#include "base/error.hpp"
#include "dataset/sets/dataset.hpp"
#include "sim/protocol/conditions.hpp"

namespace decid {
namespace {

sim::ParameterTable ranges_of_first(std::span<const sim::Protocol> protocols) {
  if (protocols.empty()) throw Error(Code::value_invalid, "calibration", "has no protocol", "give one");
  return protocols.front().ranges();
}

bool same_range(const sim::ParameterInfo& a, const sim::ParameterInfo& b) {
  return a.name == b.name && a.low == b.low && a.high == b.high;
}

}  // namespace

sim::Protocol with_priors(sim::Protocol protocol, const posterior::Priors& priors) {
  if (priors.start_s > 0.0) protocol.conditions[sim::Condition::start] = {.fraction = 1.0, .high = priors.start_s};
  // A uniform distribution with the prior's standard deviation.
  if (priors.gain > 0.0)
    protocol.conditions[sim::Condition::gain] = {.fraction = 1.0, .high = std::sqrt(3.0) * priors.gain};
  return protocol;
}

sim::Parameters uniform_stddev(const sim::ParameterTable& ranges) {
  sim::Parameters stddev(ranges.size());
  for (std::size_t p = 0; p < ranges.size(); ++p) stddev[p] = ranges[p].range() / std::sqrt(12.0);
  return stddev;
}

CalibrationTrials::CalibrationTrials(std::span<const sim::Protocol> protocols, const posterior::Priors& priors,
                                     std::uint64_t seed)
    : ranges_(ranges_of_first(protocols)), seed_(seed) {
  for (const sim::Protocol& protocol : protocols) {
    if (!std::ranges::equal(protocol.ranges(), ranges_, same_range))
      throw Error(Code::value_invalid, "protocol " + protocol.name, "has other parameters or ranges than the first",
                  "give protocols of one body and controller");
    sim::Protocol recorded = with_priors(protocol, priors);
    if (recorded.standing_s == 0.0) recorded.standing_s = priors.standing_s;
    simulators_.emplace_back(std::move(recorded));
  }
}

CalibrationTrials::Trial CalibrationTrials::next() {
  constexpr int repetition_bit = 40;  // of attempts: later recordings of a person have noise of their own
  for (int tried = 0; tried < 10'000; ++tried) {
    const std::uint64_t attempt = next_++;
    const sim::Parameters parameters =
        sim::with_conventions(dataset::base_trial(ranges_, seed_, attempt).parameters, ranges_);
    Trial trial{attempt, parameters, {}};
    bool valid = true;
    for (std::size_t k = 0; k < simulators_.size() && valid; ++k) {
      const sim::Simulator& simulator = simulators_[k];
      const std::uint64_t item = attempt + (std::uint64_t{k} << repetition_bit);
      std::vector<double> sway(static_cast<std::size_t>(simulator.protocol().samples()));
      valid = simulator.run(parameters, dataset::base_trial(ranges_, seed_, item).noise, sway).valid;
      if (!valid) break;
      sim::record(simulator.protocol(), seed_, item, sway);
      std::vector<float>& to = k == 0 ? trial.sway_rad : trial.others_rad.emplace_back();
      to.assign(sway.begin(), sway.end());
    }
    if (valid) return trial;
  }
  throw Error(Code::body_falls, "protocol " + simulators_.front().protocol().name, "10,000 trials in a row fell",
              "use a smaller stimulus or less noise");
}

std::optional<CalibratedTrial> calibrate_trial(const std::deque<posterior::Density>& densities,
                                               const CalibrationTrials::Trial& trial, const sim::ParameterTable& ranges,
                                               posterior::Settings settings, const std::function<bool()>& stop) {
  const auto begin = std::chrono::steady_clock::now();
  settings.seed = trial.attempt;
  std::vector<posterior::Observation> observations{densities.front().observe(trial.sway_rad)};
  for (std::size_t k = 0; k < trial.others_rad.size(); ++k)
    observations.push_back(densities.at(k + 1).observe(trial.others_rad[k]));
  std::vector<std::size_t> common(observations.size() > 1 ? ranges.size() : 0);  // every parameter
  std::iota(common.begin(), common.end(), std::size_t{0});
  std::vector<posterior::TargetTrial> together;
  for (std::size_t k = 0; k < observations.size(); ++k) together.push_back({&densities[k], &observations[k], common});
  const std::vector<posterior::Posterior> found = posterior::sample_joint(
      posterior::Target(std::move(together)), settings, [&](const posterior::Progress&) { return !stop(); });
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
  const Estimate found = std::move(identifier_->estimate({recording::make_trial(sway_rad)}).front());
  trial.network = found.parameters;
  if (found.distribution)
    trial.network_log_score = found.distribution->log_density(trial.truth) / static_cast<double>(trial.truth.size());
}

}  // namespace decid
