// Trials with a fault: see fault_trials.hpp.
#include "identify/evaluation/fault_trials.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

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

/// Samples that were recorded, and how they are read.
struct Recorded {
  std::vector<double> sway;
  double rate_hz;
  recording::TrialOptions options;
  Random random;
};

void keep_every(Recorded& recorded, std::size_t every) {
  std::vector<double>& sway = recorded.sway;
  for (std::size_t i = 0; i * every < sway.size(); ++i) sway[i] = sway[i * every];
  sway.resize((sway.size() + every - 1) / every);
  recorded.rate_hz /= static_cast<double>(every);
}

/// A fault and what it changes, in addition to the protocol's condition of its name.
struct TestedCondition {
  std::string name;
  const char* text;             // with %g for the size, if it has one
  std::vector<double> sizes{};  // of recordings that models are tested with; empty: only recordings of people
  void (*change)(sim::Protocol& recorded, double size) = [](sim::Protocol&, double) {};
  void (*apply)(Recorded& samples, double size) = [](Recorded&, double) {};
};

TestedCondition of_condition(Condition condition, const char* text, std::vector<double> sizes) {
  return {sim::info(condition).key, text, std::move(sizes)};
}

const std::vector<TestedCondition>& tested_conditions() {
  static const std::vector<TestedCondition> all{
      {"none", "as simulated", {0.0}},
      of_condition(Condition::start, "starts %g s early or late", {0.02, 0.05, 0.1, 0.2}),
      of_condition(Condition::gain, "sway %g of itself too large or small", {0.1, 0.2, 0.3}),
      of_condition(Condition::offset, "%g degrees added or subtracted", {0.1, 0.5, 2.0}),
      of_condition(Condition::drift, "drifts by %g degrees", {0.1, 0.5, 2.0}),
      of_condition(Condition::slow_noise, "slow noise of %g degrees", {0.02, 0.1, 0.3}),
      of_condition(Condition::frozen, "%g s in every 10 s frozen", {0.1, 0.3, 1.0}),
      of_condition(Condition::lost, "%g s in every 10 s bridged", {0.1, 0.3, 1.0}),
      of_condition(Condition::average, "moving average of %g s", {0.05, 0.11, 0.25}),
      of_condition(Condition::low_pass, "low-pass of %g Hz", {10.0, 5.0, 2.0}),
      of_condition(Condition::quantisation, "steps of %g degrees", {0.02, 0.05, 0.1, 0.2}),
      {.name = "detrend_offset",
       .text = "its mean subtracted",
       .sizes = {0.0},
       .apply = [](Recorded& samples, double) { samples.options.detrend = recording::Detrend::offset; }},
      {.name = "detrend_linear",
       .text = "a straight line subtracted",
       .sizes = {0.0},
       .apply = [](Recorded& samples, double) { samples.options.detrend = recording::Detrend::linear; }},
      {.name = "tilt",
       .text = "twice the protocol's tilt",
       .sizes = {2.0},
       .change = [](sim::Protocol& recorded, double size) { recorded.sequence().amplitude_deg *= size; }},
      {.name = "upside_down",
       .text = "with the other sign",
       .sizes = {0.0},
       .apply = [](Recorded& samples,
                   double) { std::ranges::transform(samples.sway, samples.sway.begin(), std::negate<>()); }},
      {.name = "backwards",
       .text = "backwards",
       .sizes = {0.0},
       .apply = [](Recorded& samples, double) { std::ranges::reverse(samples.sway); }},
      {"double_pendulum", "of leg and trunk", {0.0}},
      {.name = "at_rest",
       .text = "of a body at rest at the first sample",
       .change = [](sim::Protocol& recorded, double) { recorded = recorded.from_rest(); }},
      {.name = "coloured_noise_deg",
       .text = "coloured noise of %g degrees",
       .apply =
           [](Recorded& samples, double size) {
             add_coloured_noise(samples.sway, size * sim::rad_per_deg, samples.rate_hz, samples.random);
           }},
      {.name = "rate_hz",
       .text = "%g samples a second",
       .apply =
           [](Recorded& samples, double size) {
             keep_every(samples, static_cast<std::size_t>(std::floor(samples.rate_hz / size + 0.5)));
           }},
      {.name = "gap_s",
       .text = "a gap of %g s bridged by a straight line",
       .apply =
           [](Recorded& samples, double size) {
             bridge_gap(samples.sway, static_cast<std::size_t>(size * samples.rate_hz), samples.random);
           }},
      {.name = "later_part_s",
       .text = "begins %g s later in the stimulus",
       .apply =
           [](Recorded& samples, double size) {
             const auto samples_later = static_cast<std::size_t>(size * samples.rate_hz) % samples.sway.size();
             std::rotate(samples.sway.begin(), samples.sway.begin() + static_cast<std::ptrdiff_t>(samples_later),
                         samples.sway.end());
           }},
  };
  return all;
}

/// Returns null for a name that is not in the table.
const TestedCondition* find_tested(const std::string& name) {
  const std::vector<TestedCondition>& all = tested_conditions();
  const auto found = std::ranges::find(all, name, &TestedCondition::name);
  return found == all.end() ? nullptr : &*found;
}

Fault fault_of(const TestedCondition& tested, double size) {
  std::string text = tested.text;
  if (const std::size_t at = text.find("%g"); at != std::string::npos) text.replace(at, 2, format("%g", size));
  return {tested.name, size, text};
}

/// Returns the trial of samples that were recorded, with the fault, and its warnings.
std::pair<recording::Trial, Warnings> read(const Fault& fault, const sim::Protocol& protocol, std::vector<double> sway,
                                           const Random& random) {
  Recorded samples{std::move(sway), protocol.experiment.sample_rate_hz, {}, random};
  if (const TestedCondition* tested = find_tested(fault.name)) tested->apply(samples, fault.size);
  recording::Recording recording = recording::make_recording(samples.sway, samples.rate_hz);
  recording::Trial trial = recording::bring_to_protocol(recording, protocol, samples.options);
  return {std::move(trial), std::move(recording.warnings)};
}

}  // namespace

std::vector<Fault> all_faults() {
  std::vector<Fault> all;
  for (const TestedCondition& tested : tested_conditions())
    for (const double size : tested.sizes) all.push_back(fault_of(tested, size));
  return all;
}

std::vector<Fault> faults_of_people() {
  using NamesAndSizes = std::vector<std::pair<std::string, double>>;
  const NamesAndSizes chosen{{"none", 0.0},
                             {"at_rest", 0.0},
                             {"offset_deg", 0.3},
                             {"drift_deg", 0.4},
                             {"detrend_offset", 0.0},
                             {"detrend_linear", 0.0},
                             {"coloured_noise_deg", 0.02},
                             {"coloured_noise_deg", 0.05},
                             {"start_s", 0.05},
                             {"gain", 0.2},
                             {"quantisation_deg", 0.1},
                             {"low_pass_hz", 5.0},
                             {"rate_hz", 50.0},
                             {"gap_s", 2.0},
                             {"tilt", 2.0},
                             {"upside_down", 0.0},
                             {"backwards", 0.0},
                             {"later_part_s", 20.0},
                             {"double_pendulum", 0.0}};
  std::vector<Fault> all;
  for (const auto& [name, size] : chosen) all.push_back(fault_of(*find_tested(name), size));
  return all;
}

sim::Protocol with_fault(sim::Protocol protocol, const Fault& fault) {
  for (std::size_t c = 0; c < sim::condition_count; ++c)
    if (fault.name == sim::info(static_cast<Condition>(c)).key)
      protocol.conditions[static_cast<Condition>(c)] = {1.0, fault.size, fault.size};
  if (const TestedCondition* tested = find_tested(fault.name)) tested->change(protocol, fault.size);
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
        std::tie(made.sways[place], made.warnings[place]) =
            read(fault_, protocol_, {sway.begin(), sway.end()}, Random(seed_, sim::streams::recording, number));
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
