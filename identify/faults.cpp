// Faults of recordings: see faults.hpp.
#include "identify/faults.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/parallel.hpp"
#include "base/text.hpp"
#include "identify/identify.hpp"
#include "identify/prediction.hpp"
#include "sim/double_pendulum.hpp"

namespace decid {
namespace {

using sim::Condition;

/// Sizes at which a condition is looked at.
struct Looked {
  Condition condition;
  const char* what;  // with %g for the size
  std::vector<double> sizes;
};

const std::vector<Looked>& looked_at() {
  static const std::vector<Looked> all{
      {Condition::start, "starts %g s early or late", {0.02, 0.05, 0.1, 0.2}},
      {Condition::gain, "sway %g of itself too large or small", {0.1, 0.2, 0.3}},
      {Condition::offset, "%g degrees added or subtracted", {0.1, 0.5, 2.0}},
      {Condition::drift, "drifts by %g degrees", {0.1, 0.5, 2.0}},
      {Condition::slow_noise, "slow noise of %g degrees", {0.02, 0.1, 0.3}},
      {Condition::frozen, "%g s in every 10 s frozen", {0.1, 0.3, 1.0}},
      {Condition::lost, "%g s in every 10 s bridged", {0.1, 0.3, 1.0}},
      {Condition::average, "moving average of %g s", {0.05, 0.11, 0.25}},
      {Condition::low_pass, "low-pass of %g Hz", {10.0, 5.0, 2.0}},
      {Condition::quantisation, "steps of %g degrees", {0.02, 0.05, 0.1, 0.2}},
  };
  return all;
}

/// The trials of one row: as many as the parameters, or none of these if there are none that are true.
struct Trials {
  std::vector<dataset::Trial> sways;
  std::vector<char> warned;  // of what was read; bytes, which threads may write side by side
  std::vector<sim::Parameters> truth;
};

sim::Protocol with_fault(sim::Protocol protocol, const Fault& fault) {
  for (std::size_t c = 0; c < sim::condition_count; ++c)
    if (fault.name == sim::info(static_cast<Condition>(c)).key)
      protocol.conditions[static_cast<Condition>(c)] = {1.0, fault.size, fault.size};
  if (fault.name == "tilt") protocol.sequence().amplitude_deg *= fault.size;
  return protocol;
}

/// What the fault does to samples that were recorded.
dataset::Trial changed(const Fault& fault, const sim::Protocol& protocol, std::span<double> sway, char& warned) {
  dataset::TrialOptions options;
  if (fault.name == "backwards") std::ranges::reverse(sway);
  if (fault.name == "upside_down") std::ranges::transform(sway, sway.begin(), std::negate<>());
  if (fault.name == "detrend_offset") options.detrend = dataset::Detrend::offset;
  if (fault.name == "detrend_linear") options.detrend = dataset::Detrend::linear;
  dataset::Recording recording = dataset::recording_of(sway, protocol.experiment.sample_rate_hz);
  dataset::Trial trial = dataset::bring_to_protocol(recording, protocol, options);
  warned = recording.warnings.empty() ? 0 : 1;
  return trial;
}

Trials simulate(const sim::Protocol& protocol, const Fault& fault, int trials, std::uint64_t seed) {
  const auto count = static_cast<std::size_t>(trials);
  Trials made{std::vector<dataset::Trial>(count), std::vector<char>(count, 0), std::vector<sim::Parameters>(count)};
  std::vector<std::uint64_t> numbers(made.sways.size());
  std::iota(numbers.begin(), numbers.end(), std::uint64_t{0});
  const sim::Protocol recorded = with_fault(protocol, fault);
  dataset::simulate_stream(sim::Simulator(recorded.ideal()), seed, numbers,
                           [&](std::size_t place, const sim::TrialInput& trial, std::span<double> sway) {
                             sim::record(recorded, seed, place, sway);
                             made.truth[place] = trial.parameters;
                             made.sways[place] = changed(fault, protocol, sway, made.warned[place]);
                           });
  return made;
}

/// Trials of a body of leg and trunk that stood, each with another noise.
Trials simulate_double(const sim::Protocol& protocol, int trials, std::uint64_t seed) {
  const sim::DoubleSimulator simulator(protocol.ideal());
  const sim::DoubleParameters parameters = sim::default_double_parameters(simulator.segments());
  const auto samples = static_cast<std::size_t>(simulator.samples());
  std::vector<std::optional<dataset::Trial>> found(static_cast<std::size_t>(trials));
  parallel_for(trials, [&](int i) {
    std::vector<double> com(samples), leg(samples), trunk(samples);
    const auto item = static_cast<std::uint64_t>(i);
    if (!simulator.run(parameters, Random(seed, Stream::vestibular_noise, item), {com, leg, trunk}).valid) return;
    sim::record(protocol, seed, item, com);
    found[static_cast<std::size_t>(i)] = dataset::trial_of({com.begin(), com.end()});
  });
  Trials made;
  for (std::optional<dataset::Trial>& trial : found)
    if (trial) made.sways.push_back(std::move(*trial));
  made.warned.assign(made.sways.size(), 0);
  return made;
}

FaultFigures judge(const Model& model, const Fault& fault, Trials trials) {
  constexpr std::size_t at_once = 64;
  const std::size_t count = trials.sways.size();
  std::vector<sim::Parameters> found(count);
  std::vector<std::optional<CalibratedTrial>> promised(count);
  const Identifier identifier(model);
  parallel_for(static_cast<int>((count + at_once - 1) / at_once), [&](int group) {
    Identifier own(identifier);
    const std::size_t first = static_cast<std::size_t>(group) * at_once, end = std::min(count, first + at_once);
    const auto at = [&](std::size_t i) { return trials.sways.begin() + static_cast<std::ptrdiff_t>(i); };
    const std::vector<Estimate> estimates =
        own.estimate(std::vector<dataset::Trial>(std::make_move_iterator(at(first)), std::make_move_iterator(at(end))));
    const std::vector<Explanation> explanations = own.explain(estimates);
    for (std::size_t k = 0; k < estimates.size(); ++k) {
      const std::size_t i = first + k;
      found[i] = estimates[k].parameters;
      if (!estimates[k].warnings.empty() || !explanations[k].warnings.empty()) trials.warned[i] = 1;
      if (estimates[k].distribution && !trials.truth.empty())
        promised[i] = calibrate(trials.truth[i], *estimates[k].distribution);
    }
  });
  FaultFigures row{fault, {}, {}, 0.0};
  row.warned =
      static_cast<double>(std::ranges::count(trials.warned, 1)) / static_cast<double>(std::max<std::size_t>(count, 1));
  row.errors.trials = static_cast<int>(count);
  row.errors.mse_per_parameter.assign(model.parameters().size(), std::numeric_limits<double>::quiet_NaN());
  if (trials.truth.empty()) return row;
  std::vector<float> scores;
  std::vector<CalibratedTrial> said;
  for (std::size_t i = 0; i < count; ++i) {
    const std::vector<float> own = model.targets.scale(found[i]);
    scores.insert(scores.end(), own.begin(), own.end());
    if (promised[i]) said.push_back(std::move(*promised[i]));
  }
  row.errors = evaluate(model.targets, scores, trials.truth);
  if (!said.empty()) row.promises = calibration_of(said, model.targets.deviation);
  return row;
}

}  // namespace

std::vector<Fault> all_faults() {
  std::vector<Fault> all{{"none", 0.0, "as simulated"}};
  for (const Looked& of : looked_at())
    for (const double size : of.sizes) {
      std::string what = of.what;
      what.replace(what.find("%g"), 2, format("%g", size));
      all.push_back({sim::info(of.condition).key, size, what});
    }
  all.push_back({"detrend_offset", 0.0, "its mean subtracted"});
  all.push_back({"detrend_linear", 0.0, "a straight line subtracted"});
  all.push_back({"tilt", 2.0, "twice the protocol's tilt"});
  all.push_back({"upside_down", 0.0, "with the other sign"});
  all.push_back({"backwards", 0.0, "backwards"});
  all.push_back({"double_pendulum", 0.0, "of leg and trunk"});
  return all;
}

std::vector<FaultFigures> study_faults(const Model& model, double sensor_noise_deg, int trials, std::uint64_t seed,
                                       const std::function<void(const std::string&)>& announce) {
  require_not_trained_on(model.origin, {dataset::TrialIdentity::Kind::stream, seed, {}}, Measured::all, "fresh trials");
  sim::Protocol protocol = model.protocol.ideal();
  protocol.noise.sensor = {sensor_noise_deg, sensor_noise_deg};
  const bool is_sequence = std::holds_alternative<sim::Sequence>(protocol.experiment.stimulus);
  std::vector<FaultFigures> rows;
  for (const Fault& fault : all_faults()) {
    if (fault.name == "tilt" && !is_sequence) continue;
    announce(format("%d trials, %s", trials, fault.what.c_str()));
    if (fault.name != "double_pendulum") {
      rows.push_back(judge(model, fault, simulate(protocol, fault, trials, seed)));
      continue;
    }
    try {
      rows.push_back(judge(model, fault, simulate_double(protocol, trials, seed)));
    } catch (const Error&) {
      // A body that is not made of segments.
    }
  }
  return rows;
}

}  // namespace decid
