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

/// Trials of one row: as many as the parameters, or none of these if there are none that are true.
struct Trials {
  std::vector<dataset::Trial> sways;
  std::vector<char> warned;  // of what was read; bytes, which threads may write side by side
  std::vector<sim::Parameters> truth;
};

/// Trials that are simulated and judged together: 25 MB of the default protocol's.
constexpr int faults_at_once = 512;

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
  warned = trust_of(recording.warnings) == Trust::usable ? 0 : 1;
  return trial;
}

/// Why trials of the protocol cannot have the fault; empty: they can.
std::string impossible(const sim::Protocol& protocol, const Fault& fault) {
  const double rate_hz = protocol.experiment.sample_rate_hz;
  const auto is = [&](Condition condition) { return fault.name == sim::info(condition).key; };
  if (fault.name == "tilt" && !std::holds_alternative<sim::Sequence>(protocol.experiment.stimulus))
    return "the tilt is no sequence";
  if ((is(Condition::frozen) || is(Condition::lost)) && fault.size * rate_hz < 0.5) return "it is below a sample";
  if (is(Condition::average) && fault.size * rate_hz < 1.5) return "it is below two samples";
  if (is(Condition::low_pass) && fault.size > 0.48 * rate_hz) return "the rate is too low";
  return {};
}

/// Trials first, first + 1, ... of a row.
class Source {
 public:
  Source(const sim::Protocol& protocol, const Fault& fault, std::uint64_t seed)
      : protocol_(protocol), fault_(fault), recorded_(with_fault(protocol, fault)), seed_(seed) {
    if (fault.name == "double_pendulum")
      double_.emplace(protocol.ideal());
    else
      single_.emplace(recorded_.ideal());
  }

  Trials take(int first, int count) const { return double_ ? take_double(first, count) : take_single(first, count); }

 private:
  Trials take_single(int first, int count) const {
    const auto size = static_cast<std::size_t>(count);
    Trials made{std::vector<dataset::Trial>(size), std::vector<char>(size, 0), std::vector<sim::Parameters>(size)};
    std::vector<std::uint64_t> numbers(size);
    std::iota(numbers.begin(), numbers.end(), static_cast<std::uint64_t>(first));
    dataset::simulate_stream(*single_, seed_, numbers,
                             [&](std::size_t place, const sim::TrialInput& trial, std::span<double> sway) {
                               sim::record(recorded_, seed_, numbers[place], sway);
                               made.truth[place] = trial.parameters;
                               made.sways[place] = changed(fault_, protocol_, sway, made.warned[place]);
                             });
    return made;
  }

  /// Those that stood, each with another noise.
  Trials take_double(int first, int count) const {
    const sim::DoubleParameters parameters = sim::default_double_parameters(double_->segments());
    const auto samples = static_cast<std::size_t>(double_->samples());
    std::vector<std::optional<dataset::Trial>> found(static_cast<std::size_t>(count));
    parallel_for(count, [&](int i) {
      std::vector<double> com(samples), leg(samples), trunk(samples);
      const auto item = static_cast<std::uint64_t>(first + i);
      if (!double_->run(parameters, Random(seed_, Stream::vestibular_noise, item), {com, leg, trunk}).valid) return;
      sim::record(protocol_, seed_, item, com);
      found[static_cast<std::size_t>(i)] = dataset::trial_of({com.begin(), com.end()});
    });
    Trials made;
    for (std::optional<dataset::Trial>& trial : found)
      if (trial) made.sways.push_back(std::move(*trial));
    made.warned.assign(made.sways.size(), 0);
    return made;
  }

  const sim::Protocol& protocol_;
  const Fault& fault_;
  sim::Protocol recorded_;
  std::uint64_t seed_;
  std::optional<sim::Simulator> single_;
  std::optional<sim::DoubleSimulator> double_;
};

/// A row while its trials are judged.
struct Row {
  std::vector<float> scores;
  std::vector<sim::Parameters> truth;
  std::vector<CalibratedTrial> said;
  int trials = 0, warned = 0;
};

void judge(const Identifier& identifier, Trials trials, Row& row) {
  constexpr std::size_t group_size = 64;
  const Model& model = identifier.model();
  const std::size_t count = trials.sways.size();
  std::vector<sim::Parameters> found(count);
  std::vector<std::optional<CalibratedTrial>> promised(count);
  parallel_for(static_cast<int>((count + group_size - 1) / group_size), [&](int group) {
    Identifier own(identifier);
    const std::size_t first = static_cast<std::size_t>(group) * group_size, end = std::min(count, first + group_size);
    const auto at = [&](std::size_t i) { return trials.sways.begin() + static_cast<std::ptrdiff_t>(i); };
    const std::vector<Estimate> estimates =
        own.estimate(std::vector<dataset::Trial>(std::make_move_iterator(at(first)), std::make_move_iterator(at(end))));
    const std::vector<Explanation> explanations = own.explain(estimates);
    for (std::size_t k = 0; k < estimates.size(); ++k) {
      const std::size_t i = first + k;
      found[i] = estimates[k].parameters;
      if (trust_of(estimates[k].warnings) != Trust::usable || trust_of(explanations[k].warnings) != Trust::usable)
        trials.warned[i] = 1;
      if (estimates[k].distribution && !trials.truth.empty())
        promised[i] = calibrate(trials.truth[i], *estimates[k].distribution);
    }
  });
  row.trials += static_cast<int>(count);
  row.warned += static_cast<int>(std::ranges::count(trials.warned, 1));
  for (std::size_t i = 0; i < trials.truth.size(); ++i) {
    const std::vector<float> own = model.targets.scale(found[i]);
    row.scores.insert(row.scores.end(), own.begin(), own.end());
    if (promised[i]) row.said.push_back(std::move(*promised[i]));
  }
  row.truth.insert(row.truth.end(), trials.truth.begin(), trials.truth.end());
}

FaultFigures figures(const Model& model, const Fault& fault, const Row& row) {
  FaultFigures made{fault, {}, {}, static_cast<double>(row.warned) / row.trials};
  if (row.truth.empty()) {
    made.errors.trials = row.trials;
    made.errors.mse_per_parameter.assign(model.parameters().size(), std::numeric_limits<double>::quiet_NaN());
    return made;
  }
  made.errors = evaluate(model.targets, row.scores, row.truth);
  if (!row.said.empty()) made.promises = calibration_of(row.said, model.targets.deviation);
  return made;
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

FaultStudy study_faults(const Model& model, double sensor_noise_deg, int trials, std::uint64_t seed,
                        const std::function<void(const std::string&)>& announce) {
  require_not_trained_on(model.origin, {dataset::TrialIdentity::Kind::stream, seed, {}}, Measured::all, "fresh trials");
  sim::Protocol protocol = model.protocol.ideal();
  protocol.noise.sensor = {sensor_noise_deg, sensor_noise_deg};
  const Identifier identifier(model);
  FaultStudy study;
  for (const Fault& fault : all_faults()) {
    std::string missing = impossible(protocol, fault);
    std::optional<Source> source;
    Row row;
    // A tilt that is too large, a body without segments, a controller that falls.
    try {
      if (missing.empty()) source.emplace(protocol, fault, seed);
      for (int first = 0; source && first < trials; first += faults_at_once) {
        const int count = std::min(faults_at_once, trials - first);
        announce(format("trials %d to %d of %d, %s", first + 1, first + count, trials, fault.what.c_str()));
        Trials taken = source->take(first, count);
        judge(identifier, std::move(taken), row);
      }
    } catch (const Error& error) {
      if (fault.name != "tilt" && fault.name != "double_pendulum") throw;
      missing = error.what();
    }
    if (missing.empty() && row.trials == 0) missing = "none of its trials stands";
    if (missing.empty())
      study.rows.push_back(figures(model, fault, row));
    else
      study.notes.push_back("no row of recordings " + fault.what + ": " + missing);
  }
  return study;
}

}  // namespace decid
