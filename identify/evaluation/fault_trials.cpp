// Trials with a fault: see fault_trials.hpp.
#include "identify/evaluation/fault_trials.hpp"

#include <algorithm>
#include <cmath>

#include "base/math/math.hpp"
#include "base/math/random.hpp"
#include "base/parallel.hpp"
#include "base/text.hpp"
#include "dataset/sets/dataset.hpp"
#include "sim/streams.hpp"

namespace decid {
namespace {

using sim::Condition;

constexpr double memory_s = 0.495;  // of coloured noise: 0.98 of it is left after 10 ms

// Random numbers of sim::streams::recording beyond the numbers that record() uses.
constexpr std::uint64_t of_coloured_noise = std::uint64_t{1} << 40, of_gap = std::uint64_t{1} << 41;

/// Sizes at which a condition is tested.
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

void add_coloured_noise(std::span<double> sway, double stddev, double rate_hz, const Random& random) {
  const double kept = decid::exp(-1.0 / (memory_s * rate_hz)), fresh = std::sqrt(1.0 - kept * kept);
  std::vector<double> normals(sway.size());
  random.fill_normal(normals, of_coloured_noise);
  double noise = normals.front();
  for (std::size_t i = 0; i < sway.size(); ++i) {
    if (i > 0) noise = kept * noise + fresh * normals[i];
    sway[i] += stddev * noise;
  }
}

/// Bridges `length` samples by a straight line, at a random place.
void bridge_gap(std::span<double> sway, std::size_t length, const Random& random) {
  if (length + 2 > sway.size()) return;
  const auto first =
      1 + static_cast<std::size_t>(random.uniform(of_gap) * static_cast<double>(sway.size() - length - 2));
  const double before = sway[first - 1], step = (sway[first + length] - before) / static_cast<double>(length + 1);
  for (std::size_t i = 0; i < length; ++i) sway[first + i] = before + step * static_cast<double>(i + 1);
}

/// Reads samples that were recorded, with the fault.
recording::Trial read(const Fault& fault, const sim::Protocol& protocol, std::vector<double> sway, const Random& random,
                      Warnings& warnings) {
  recording::TrialOptions options;
  double rate_hz = protocol.experiment.sample_rate_hz;
  if (fault.name == "backwards") std::ranges::reverse(sway);
  if (fault.name == "upside_down") std::ranges::transform(sway, sway.begin(), std::negate<>());
  if (fault.name == "detrend_offset") options.detrend = recording::Detrend::offset;
  if (fault.name == "detrend_linear") options.detrend = recording::Detrend::linear;
  if (fault.name == "coloured_noise_deg") add_coloured_noise(sway, fault.size * sim::rad_per_deg, rate_hz, random);
  if (fault.name == "gap_s") bridge_gap(sway, static_cast<std::size_t>(fault.size * rate_hz), random);
  if (fault.name == "rate_hz") {
    const auto every = static_cast<std::size_t>(std::floor(rate_hz / fault.size + 0.5));
    for (std::size_t i = 0; i * every < sway.size(); ++i) sway[i] = sway[i * every];
    sway.resize((sway.size() + every - 1) / every);
    rate_hz /= static_cast<double>(every);
  }
  recording::Recording recording = recording::make_recording(sway, rate_hz);
  recording::Trial trial = recording::bring_to_protocol(recording, protocol, options);
  warnings = std::move(recording.warnings);
  return trial;
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

std::vector<Fault> faults_of_people() {
  return {{"none", 0.0, "as simulated"},
          {"at_rest", 0.0, "of a body at rest at the first sample"},
          {"offset_deg", 0.3, "0.3 degrees added or subtracted"},
          {"drift_deg", 0.4, "drifts by 0.4 degrees"},
          {"detrend_offset", 0.0, "its mean subtracted"},
          {"detrend_linear", 0.0, "a straight line subtracted"},
          {"coloured_noise_deg", 0.02, "coloured noise of 0.02 degrees"},
          {"coloured_noise_deg", 0.05, "coloured noise of 0.05 degrees"},
          {"start_s", 0.05, "starts 0.05 s early or late"},
          {"gain", 0.2, "sway 0.2 of itself too large or small"},
          {"quantisation_deg", 0.1, "steps of 0.1 degrees"},
          {"low_pass_hz", 5.0, "low-pass of 5 Hz"},
          {"rate_hz", 50.0, "50 samples a second"},
          {"gap_s", 2.0, "a gap of 2 s bridged by a straight line"},
          {"tilt", 2.0, "twice the protocol's tilt"},
          {"upside_down", 0.0, "with the other sign"},
          {"backwards", 0.0, "backwards"},
          {"double_pendulum", 0.0, "of leg and trunk"}};
}

sim::Protocol with_fault(sim::Protocol protocol, const Fault& fault) {
  for (std::size_t c = 0; c < sim::condition_count; ++c)
    if (fault.name == sim::info(static_cast<Condition>(c)).key)
      protocol.conditions[static_cast<Condition>(c)] = {1.0, fault.size, fault.size};
  if (fault.name == "tilt") protocol.sequence().amplitude_deg *= fault.size;
  if (fault.name == "at_rest") protocol.standing_s = 0.0;
  return protocol;
}

std::string impossible(const sim::Protocol& protocol, const Fault& fault) {
  const double rate_hz = protocol.experiment.sample_rate_hz;
  const auto is = [&](Condition condition) { return fault.name == sim::info(condition).key; };
  if (fault.name == "tilt" && !std::holds_alternative<sim::Sequence>(protocol.experiment.stimulus))
    return "the tilt is not a sequence";
  if ((is(Condition::frozen) || is(Condition::lost)) && fault.size * rate_hz < 0.5) return "it is below a sample";
  if (is(Condition::average) && fault.size * rate_hz < 1.5) return "it is below two samples";
  if (fault.name == "rate_hz" && fault.size > 0.5 * rate_hz) return "the protocol has no more than that";
  if (is(Condition::low_pass) && fault.size > 0.48 * rate_hz) return "the rate is too low";
  return {};
}

FaultTrials::FaultTrials(const sim::Protocol& protocol, const sim::Protocol& recorded, const Fault& fault,
                         std::uint64_t seed)
    : protocol_(protocol), recorded_(recorded), fault_(fault), seed_(seed) {
  if (fault.name == "double_pendulum")
    double_.emplace(protocol.ideal());
  else
    single_.emplace(recorded.ideal());
}

FaultTrials::Trials FaultTrials::take(int first, int count) const {
  return double_ ? take_double(first, count) : take_single(first, count);
}

FaultTrials::Trials FaultTrials::take_single(int first, int count) const {
  const auto size = static_cast<std::size_t>(count);
  Trials made{std::vector<recording::Trial>(size), std::vector<Warnings>(size), std::vector<sim::Parameters>(size)};
  const sim::ParameterTable ranges = single_->protocol().ranges();
  const auto number_of = [first](int i) { return static_cast<std::uint64_t>(first + i); };
  // The attempts are those of dataset::simulate_stream(), with conventions.
  constexpr int attempts = 1024;
  single_->run_until_valid(
      count, attempts,
      [&](int i, int attempt) {
        sim::TrialInput trial = dataset::base_trial(
            ranges, seed_, number_of(i) * attempts + static_cast<std::uint64_t>(attempt), single_->protocol().heights);
        trial.parameters = sim::with_conventions(trial.parameters, ranges);
        return trial;
      },
      [&](int i, const sim::TrialInput& trial, std::span<double> sway) {
        const auto place = static_cast<std::size_t>(i);
        const std::uint64_t number = number_of(i);
        sim::record(recorded_, seed_, number, sway);
        made.truth[place] = trial.parameters;
        made.sways[place] = read(fault_, protocol_, {sway.begin(), sway.end()},
                                 Random(seed_, sim::streams::recording, number), made.warnings[place]);
      });
  return made;
}

FaultTrials::Trials FaultTrials::take_double(int first, int count) const {
  const sim::DoubleParameters parameters = sim::default_double_parameters(double_->segments());
  const auto samples = static_cast<std::size_t>(double_->samples());
  std::vector<std::optional<recording::Trial>> found(static_cast<std::size_t>(count));
  parallel_for(count, [&](int i) {
    std::vector<double> com(samples), leg(samples), trunk(samples);
    const auto item = static_cast<std::uint64_t>(first + i);
    if (!double_->run(parameters, Random(seed_, sim::streams::vestibular_noise, item), {com, leg, trunk}).valid) return;
    sim::record(recorded_, seed_, item, com);
    found[static_cast<std::size_t>(i)] = recording::make_trial({com.begin(), com.end()});
  });
  Trials made;
  for (std::optional<recording::Trial>& trial : found)
    if (trial) made.sways.push_back(std::move(*trial));
  made.warnings.resize(made.sways.size());
  return made;
}

}  // namespace decid
