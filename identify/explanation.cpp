// How well parameters explain a trial: see explanation.hpp.
#include "identify/explanation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "base/math/statistics.hpp"
#include "base/parallel.hpp"
#include "base/setting.hpp"
#include "base/text.hpp"
#include "identify/detail/as_recorded.hpp"
#include "sim/streams.hpp"

namespace decid {
namespace {

/// Number of noisy trials that the noise-free trial is compared with, in the same way as with the recording.
constexpr int compared = 5;
/// Trials of one answer: those with noise and the noise-free one.
constexpr int trials_of_answer = ResponseRatio::trials + 1;
/// Answers that are simulated together: 264 trials fill the lanes, and take 25 MB.
constexpr std::size_t together = 8;
constexpr int min_cycles_to_skip_one = 3;

struct Residual {
  double rms_deg, variance_accounted_for;
};

/// Returns the rms residual of the trial `fitted`, degrees, and the fraction of the variance of `sway` that it
/// explains, means removed. NaN if it fell over before its end.
Residual residual_of(std::span<const float> sway, std::span<const float> fitted) {
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

/// Returns the samples before the body fell.
std::span<double> samples_until_fall(const sim::Outcome& outcome, std::span<double> sway_rad, double rate_hz) {
  if (outcome.valid) return sway_rad;
  return sway_rad.first(std::min(outcome.samples(rate_hz), sway_rad.size()));
}

/// Makes a simulated sway what the recording would have of it.
void make_as_recorded(const Answer& answer, double rate_hz, std::span<double> sway_rad) {
  if (answer.start_s != 0.0) std::ranges::copy(started_later(sway_rad, answer.start_s * rate_hz), sway_rad.begin());
  for (double& value : sway_rad) value *= answer.gain;
  bridge_gaps(sway_rad, answer.trial.gaps);
}

/// Subtracts the straight line of the residual from `sway`, about its middle. Returns the line's rise in degrees.
double subtract_drift(std::vector<float>& sway, std::span<const float> fitted) {
  const double n = static_cast<double>(sway.size()), middle = 0.5 * (n - 1.0);
  double product = 0;
  for (std::size_t k = 0; k < sway.size(); ++k)
    product += (static_cast<double>(k) - middle) * (static_cast<double>(sway[k]) - static_cast<double>(fitted[k]));
  const double slope = product / (n * (n * n - 1.0) / 12.0);
  for (std::size_t k = 0; k < sway.size(); ++k)
    sway[k] -= static_cast<float>(slope * (static_cast<double>(k) - middle));
  return slope * n / sim::rad_per_deg;
}

/// Warns if the residual is larger than noise explains, and names a drift that explains it.
void warn_of_residual(std::span<const float> sway_rad, std::span<const std::vector<float>> noisy, Severity severity,
                      Explanation& explanation) {
  if (!std::isfinite(explanation.variance_accounted_for)) {
    add_invalid(
        explanation.warnings, "does_not_stand",
        "the identified controller does not stand: the simulated body falls, so decid reports no goodness of fit");
    return;
  }
  std::vector<double> usual;
  for (const std::vector<float>& trial : noisy) {
    if (trial.size() < explanation.fitted_rad.size()) continue;  // skips a trial that fell
    usual.push_back(residual_of(trial, explanation.fitted_rad).variance_accounted_for);
  }
  if (usual.empty()) {
    add_caution(explanation.warnings, "barely_stands",
                "the identified controller stands without its noise but falls with it: it is close to instability");
    return;
  }
  const auto [low, high] = std::ranges::minmax(usual);
  const double lowest_usual = low - (high - low) - 0.1;
  if (explanation.variance_accounted_for >= lowest_usual) return;
  std::vector<float> straight(sway_rad.begin(), sway_rad.end());
  const double drift_deg = subtract_drift(straight, explanation.fitted_rad);
  const double without_drift = residual_of(straight, explanation.fitted_rad).variance_accounted_for;
  if (without_drift >= lowest_usual && without_drift > 0.0) {  // a line that leaves nothing explained is no cause
    explanation.warnings.push_back(
        {severity, "drift",
         format("the sway drifts by %.2g degrees over the trial, which the identified controller does not explain: "
                "without this line it explains %.0f%% of the variance, with it %.0f%%; ",
                drift_deg, 100 * without_drift, 100 * std::max(0.0, explanation.variance_accounted_for)) +
             setting("detrend") + " linear subtracts it"});
    return;
  }
  explanation.warnings.push_back(
      {severity, "little_explained",
       format(
           "the identified controller, without noise, explains %.0f%% of the recording's variance, where it explains "
           "%.0f to %.0f%% of simulated trials with its noise: the recording may not be of this protocol or of this "
           "kind "
           "of controller",
           100 * std::max(0.0, explanation.variance_accounted_for), 100 * low, 100 * high)});
}

/// Returns how far the first two cycles of a sway differ slowly, in degrees: the rms of the first and second harmonic
/// of their difference, without its mean, over the square root of 2. A straight drift cancels. 0 for cycles under 40 s.
double slow_difference_deg(std::span<const float> sway_rad, const sim::Experiment& experiment) {
  constexpr double min_cycle_s = 40.0, block_s = 0.5;
  const double rate_hz = experiment.sample_rate_hz;
  if (experiment.cycles() < 2 || experiment.cycle_s() < min_cycle_s) return 0.0;
  const auto samples_of = [&](double time_s) { return static_cast<std::size_t>(std::round(time_s * rate_hz)); };
  const std::size_t begin = samples_of(experiment.lead_in_s()), length = samples_of(experiment.cycle_s());
  if (begin + 2 * length > sway_rad.size()) return 0.0;  // the body fell
  const std::span<const float> first = sway_rad.subspan(begin), second = first.subspan(length);
  const std::size_t block = std::max<std::size_t>(1, samples_of(block_s)), blocks = length / block;
  double power = 0.0;
  std::vector<double> difference(blocks, 0.0);
  for (std::size_t k = 0; k < blocks * block; ++k)
    difference[k / block] += static_cast<double>(second[k]) - static_cast<double>(first[k]);
  const double values = static_cast<double>(blocks * block);
  for (const std::size_t harmonic : {std::size_t{1}, std::size_t{2}}) {
    double sine = 0.0, cosine = 0.0;
    for (std::size_t i = 0; i < blocks; ++i) {
      const SinCos at = sincos_of_turn(static_cast<long long>(harmonic * i), static_cast<long long>(blocks));
      sine += at.sin * difference[i];
      cosine += at.cos * difference[i];
    }
    power += 2.0 * (sine * sine + cosine * cosine) / (values * values);
  }
  return std::sqrt(0.5 * power) / sim::rad_per_deg;
}

/// Warns if the cycles differ slowly, and by far more than in simulated trials of the identified controller.
void warn_of_slow_lean(std::span<const float> sway_rad, std::span<const std::vector<float>> noisy,
                       const sim::Experiment& experiment, Severity severity, Explanation& explanation) {
  constexpr double min_deg = 0.4, max_ratio = 2.4;
  const double found_deg = slow_difference_deg(sway_rad, experiment);
  if (found_deg < min_deg) return;
  double squares = 0.0, count = 0.0;
  for (const std::vector<float>& trial : noisy) {
    if (trial.size() < sway_rad.size()) continue;  // skips a trial that fell
    const double usual_deg = slow_difference_deg(trial, experiment);
    squares += usual_deg * usual_deg;
    count += 1.0;
  }
  if (count == 0.0 || found_deg * found_deg * count <= max_ratio * max_ratio * squares) return;
  explanation.warnings.push_back(
      {severity, "slow_lean",
       format("the first two cycles of the sway differ slowly by %.2f degrees rms, and those of simulated trials by "
              "%.2f. The person leaned slowly to and fro, or the sensor wandered: Kp and Kp_pass may be too small. "
              "Look at the sway, and repeat the trial with the person in one position",
              found_deg, std::sqrt(squares / count))});
}

}  // namespace

/// An answer's trials up to where the body falls.
struct Explainer::Simulated {
  std::vector<float> fitted;
  std::array<std::vector<float>, compared> noisy;
  ResponseRatio::Simulated sways;
};

Explainer::Explainer(const sim::Simulator& simulator) : simulator_(simulator) {
  const sim::Protocol& protocol = simulator_.protocol();
  const std::vector<double> tilt_rad = sim::tilt_at_samples(protocol.experiment, simulator_.stimulus());
  tilt_rad_.assign(tilt_rad.begin(), tilt_rad.end());
  try {
    response_ratio_.emplace(protocol);
  } catch (const Error&) {  // it stays unknown
  }
  try {
    frf_.emplace(frequency_analysis(protocol.experiment));
  } catch (const Error& error) {
    no_frf_ = "no frequency response: " + error.problem();
  }
}

std::vector<Explainer::Simulated> Explainer::simulate(std::span<const Answer> answers) const {
  std::vector<Simulated> all(answers.size());
  std::vector<sim::Parameters> with_noise;
  for (const Answer& answer : answers)
    with_noise.push_back(simulator_.protocol().parameters().simulable(answer.parameters));
  const sim::Family& family = simulator_.protocol().family();
  simulator_.run_all(
      trials_of_answer * static_cast<int>(answers.size()),
      [&](int i) {
        const int trial = i % trials_of_answer - 1;
        const sim::Parameters& parameters = with_noise[static_cast<std::size_t>(i / trials_of_answer)];
        return sim::TrialInput{
            trial < 0 ? family.without_noise(parameters) : parameters,
            Random(0, sim::streams::vestibular_noise, static_cast<std::uint64_t>(std::max(trial, 0)))};
      },
      [&](int i, const sim::Outcome& outcome, std::span<double> sway) {
        const int trial = i % trials_of_answer - 1;
        const double rate_hz = simulator_.protocol().experiment.sample_rate_hz;
        const std::span<double> part = samples_until_fall(outcome, sway, rate_hz);
        make_as_recorded(answers[static_cast<std::size_t>(i / trials_of_answer)], rate_hz, part);
        Simulated& simulated = all[static_cast<std::size_t>(i / trials_of_answer)];
        if (trial >= 0 && outcome.valid) simulated.sways.put(trial, sway);
        if (trial >= compared) return;
        std::vector<float>& kept = trial < 0 ? simulated.fitted : simulated.noisy[static_cast<std::size_t>(trial)];
        kept.assign(part.begin(), part.end());
      });
  return all;
}

Explanation Explainer::explain(const Answer& answer, Simulated simulated) const {
  Explanation explanation;
  explanation.fitted_rad = std::move(simulated.fitted);
  explanation.gain = answer.gain;
  const std::vector<float> sway_rad = with_bridged_gaps(answer.trial.sway_rad(), answer.trial.gaps);
  const Residual found = residual_of(sway_rad, explanation.fitted_rad);
  explanation.rms_residual_deg = found.rms_deg;
  explanation.variance_accounted_for = found.variance_accounted_for;
  warn_of_residual(sway_rad, simulated.noisy, answer.little_explained, explanation);
  warn_of_slow_lean(sway_rad, simulated.noisy, simulator_.protocol().experiment, answer.little_explained, explanation);
  if (response_ratio_) {
    ResponseRatio::Spread spread;
    explanation.response_ratio = response_ratio_->measure(simulated.sways, sway_rad, &spread);
    explanation.response_ratio_mean = spread.mean;
    explanation.response_ratio_sd = spread.sd;
  }
  if (frf_)
    explanation.frf = frequency_responses(*frf_, answer, sway_rad, explanation.fitted_rad, tilt_rad_,
                                          simulator_.protocol().experiment);
  else
    add_info(explanation.warnings, "no_frequency_response", no_frf_);
  return explanation;
}

std::vector<Explanation> Explainer::explain(std::span<const Answer> answers) const {
  std::vector<Explanation> all(answers.size());
  for (std::size_t first = 0; first < answers.size(); first += together) {
    const auto some = answers.subspan(first, std::min(together, answers.size() - first));
    std::vector<Simulated> simulated = simulate(some);
    parallel_for(static_cast<int>(some.size()), [&](int i) {
      const auto place = static_cast<std::size_t>(i);
      all[first + place] = explain(some[place], std::move(simulated[place]));
    });
  }
  return all;
}

std::vector<float> noise_free_trial(const sim::Simulator& simulator, const sim::Parameters& parameters) {
  std::vector<double> sway(static_cast<std::size_t>(simulator.samples()));
  const sim::Protocol& protocol = simulator.protocol();
  const sim::Outcome outcome =
      simulator.run(protocol.family().without_noise(protocol.parameters().simulable(parameters)),
                    Random(0, sim::streams::vestibular_noise, 0), sway);
  const auto part = samples_until_fall(outcome, sway, simulator.protocol().experiment.sample_rate_hz);
  return {part.begin(), part.end()};
}

sim::FrequencyResponse frequency_analysis(const sim::Experiment& experiment) {
  return sim::FrequencyResponse(experiment, experiment.cycles() >= min_cycles_to_skip_one ? 1 : 0);
}

FrequencyResponses frequency_responses(const sim::FrequencyResponse& analysis, const Answer& answer,
                                       std::span<const float> sway_rad, std::span<const float> fitted_rad,
                                       std::span<const float> tilt_rad, const sim::Experiment& experiment) {
  FrequencyResponses found;
  found.cycles = analysis.cycles();
  const recording::Signal<float>* measured = answer.trial.signals.find(recording::platform_tilt);
  found.recorded = analysis.measure(sway_rad, measured ? measured->rad : tilt_rad);
  if (fitted_rad.size() == sway_rad.size()) found.model = analysis.measure(fitted_rad, tilt_rad);
  found.linear = analysis.linear(experiment, answer.parameters, answer.start_s);
  for (sim::Complex& response : found.linear) response = response * answer.gain;
  return found;
}

Warnings without_refused_lean(Warnings warnings) {
  constexpr std::array<std::string_view, 6> refusals{"out_of_distribution", "impossible_value", "does_not_stand",
                                                     "weak_response",       "large_response",   "large_sway"};
  const bool is_refused = std::ranges::any_of(
      warnings, [&](const Warning& warning) { return std::ranges::find(refusals, warning.code) != refusals.end(); });
  if (is_refused) std::erase_if(warnings, [](const Warning& warning) { return warning.code == "slow_lean"; });
  return warnings;
}

Warnings response_ratio_warnings(const Explanation& explanation, bool start_explains) {
  Warnings warnings;
  constexpr double min_ratio = 0.3, max_ratio = 2.0, significant_sd = 4.0;
  const double ratio = explanation.response_ratio * explanation.gain;
  const double mean = explanation.response_ratio_mean, sd = explanation.response_ratio_sd;
  if (std::isnan(ratio) || std::abs(ratio - mean) < significant_sd * sd) return warnings;
  if (ratio < min_ratio * mean && !start_explains)
    add_caution(
        warnings, "weak_response",
        format("the sway hardly follows the protocol's tilt: %.2f of the response that the identified controller "
               "would have (%.2f +- %.2f among its trials): check the protocol and the start of the recording",
               ratio, mean, sd));
  if (ratio > max_ratio * mean)
    add_caution(warnings, "large_response",
                format("the sway follows the protocol's tilt %.2f times as much as the identified controller would "
                       "(%.2f +- %.2f among its trials): was the tilt larger, or the sway in another unit?",
                       ratio, mean, sd));
  return warnings;
}

}  // namespace decid
