// Fits of recordings as laboratories make them: see fit_conditions.hpp.
#include "identify/fit_conditions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "dataset/sets/dataset.hpp"
#include "sim/simulate.hpp"

namespace decid {
namespace {

/// A trial without measurement noise and conditions, by which random numbers draw both.
struct TestTrial {
  std::uint64_t attempt;
  sim::Parameters truth;
  std::vector<double> sway_rad;
};

std::vector<TestTrial> test_trials(const sim::Protocol& protocol, int count, std::uint64_t seed) {
  const sim::Simulator simulator(protocol.ideal());
  const sim::ParameterTable ranges = protocol.ranges();
  std::vector<TestTrial> trials;
  std::vector<double> sway(static_cast<std::size_t>(protocol.samples()));
  constexpr std::uint64_t max_attempts = 1'000'000;
  for (std::uint64_t attempt = 0; static_cast<int>(trials.size()) < count; ++attempt) {
    if (attempt == max_attempts)
      throw Error("protocol " + protocol.name, "has hardly a trial that stands",
                  "use a smaller stimulus or less noise");
    const sim::TrialInput input = dataset::base_trial(ranges, seed, attempt);
    if (simulator.run(input.parameters, input.noise, sway).valid) trials.push_back({attempt, input.parameters, sway});
  }
  return trials;
}

/// Names and protocols of the rows.
std::vector<std::pair<std::string, sim::Protocol>> rows_of(const sim::Protocol& protocol) {
  sim::Protocol none = protocol;
  none.conditions = {};
  std::vector<std::pair<std::string, sim::Protocol>> rows{{"none", none}};
  for (std::size_t c = 0; c < sim::condition_count; ++c) {
    const auto condition = static_cast<sim::Condition>(c);
    if (protocol.conditions[condition].share == 0.0) continue;
    sim::Protocol alone = none;
    alone.conditions[condition] = protocol.conditions[condition];
    alone.conditions[condition].share = 1.0;
    rows.emplace_back(sim::info(condition).key, alone);
  }
  if (rows.size() > 2) rows.emplace_back("all", protocol);
  return rows;
}

FitConditionFigures figures_of(std::string name, const Model& model, const sim::Protocol& recorded,
                               const std::vector<TestTrial>& trials, const FitRequest& request, std::uint64_t seed) {
  FitConditionFigures row;
  row.name = std::move(name);
  std::vector<Identification> recordings(trials.size());
  for (std::size_t i = 0; i < trials.size(); ++i) {
    std::vector<double> sway = trials[i].sway_rad;
    sim::record(recorded, seed, trials[i].attempt, sway);
    recordings[i].file = "trial " + std::to_string(trials[i].attempt);
    recordings[i].estimate.trial = dataset::trial_of({sway.begin(), sway.end()});
  }
  const FittedRecordings fitted =
      fit_recordings(&model, recorded, std::move(recordings), std::optional<sim::Body>(), request);
  const sim::ParameterTable ranges = recorded.ranges();
  sim::Parameters sd(ranges.size());
  for (std::size_t p = 0; p < ranges.size(); ++p) sd[p] = ranges[p].range() / std::sqrt(12.0);
  std::vector<CalibratedTrial> answers;
  for (std::size_t i = 0; i < trials.size(); ++i) {
    const Identification& id = fitted.identified.recordings[i];
    const FitFigures& fit = fitted.fits[i];
    if (id.error) throw Error(*id.error);
    const bool from_network = fit.answer == FitFigures::Answer::network && id.estimate.distribution;
    answers.push_back(from_network ? calibrate(trials[i].truth, *id.estimate.distribution)
                                   : calibrate(trials[i].truth, fit.posterior, ranges));
    row.from_network += from_network ? 1 : 0;
    const Trust trust = id.trust();
    row.usable += trust == Trust::usable ? 1 : 0;
    row.caution += trust == Trust::caution ? 1 : 0;
    row.not_usable += trust == Trust::not_usable ? 1 : 0;
    row.mean_s += fit.seconds / static_cast<double>(trials.size());
    row.max_s = std::max(row.max_s, fit.seconds);
  }
  row.figures = calibration_of(answers, sd);
  return row;
}

}  // namespace

std::vector<FitConditionFigures> fit_conditions(const Model& model, const sim::Protocol& protocol,
                                                const FitRequest& request, int trials, std::uint64_t seed,
                                                const std::function<bool(const std::string& name)>& announce) {
  const std::vector<TestTrial> made = test_trials(protocol, trials, seed);
  std::vector<FitConditionFigures> rows;
  for (const auto& [name, recorded] : rows_of(protocol)) {
    if (!announce(name)) break;
    rows.push_back(figures_of(name, model, recorded, made, request, seed));
  }
  return rows;
}

}  // namespace decid
