// Identification: see identify.hpp.
#include "identify/identify.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/setting.hpp"
#include "base/text.hpp"
#include "identify/recordings.hpp"

namespace decid {
namespace {

void warn_of_ranges(const sim::ParameterTable& table, Estimate& estimate) {
  for (std::size_t p = 0; p < table.size(); ++p) {
    const sim::ParameterInfo& info = table[p];
    const double value = estimate.parameters[p];
    if (!info.is_beyond(value)) continue;
    const std::string trained = format("(%g to %g%s)", info.low, info.high, info.unit_after().c_str());
    if (value < 0.0)
      add_invalid(estimate.warnings, "impossible_value",
                  format("%s = %.4g is negative, which is impossible; the model was trained on a range %s",
                         info.name.c_str(), value, trained.c_str()));
    else
      add_caution(estimate.warnings, "outside_range",
                  format("%s = %.4g lies outside the range the model was trained on %s", info.name.c_str(), value,
                         trained.c_str()));
  }
}

/// MSE limit: guessing the middle of the ranges gives 1. The built-in model has 0.57 on the worst recording condition
/// of its training, slow noise of 0.3°. After the first of its 128 epochs it had 0.70.
constexpr double max_validation_mse = 0.6;

/// Adds a warning if the network identifies its own validation trials hardly better than a guess.
void warn_of_model(const Model& model, Estimate& estimate) {
  const std::optional<double> error = model.validation_mse();
  if (!error || *error <= max_validation_mse) return;
  add_caution(estimate.warnings, "imprecise_model",
              format("the model is hardly better than guessing: its squared error on validation trials is %.2f of "
                     "the parameters' variance (1 is guessing, above %g is imprecise); train it longer, or on more "
                     "trials",
                     *error, max_validation_mse));
}

/// Returns the upper bound of a condition in the training, 0 if the condition never occurs.
double largest(const sim::Conditions& conditions, sim::Condition condition) {
  return conditions[condition].fraction > 0.0 ? conditions[condition].high : 0.0;
}

void warn_of_sway(const sim::Conditions& trained, const recording::Trial& trial, Estimate& estimate) {
  const std::vector<float>& sway_rad = trial.sway_rad();
  // Simulated trials swing about upright: of 2,000 none has a mean beyond this.
  const double moved_deg = largest(trained, sim::Condition::offset) + largest(trained, sim::Condition::drift);
  const double max_mean_deg = 0.8 + moved_deg;
  double sum = 0;
  for (const float value : sway_rad) sum += static_cast<double>(value);
  const double mean_deg = sum / static_cast<double>(sway_rad.size()) / sim::rad_per_deg;
  if (std::abs(mean_deg) > max_mean_deg)
    add_caution(estimate.warnings, "sway_off_upright",
                format("the sway's mean is %.2f degrees, where 0 should be upright: an offset of the sensor "
                       "shifts the result; ",
                       mean_deg) +
                    setting("detrend") + " offset subtracts it");
  const auto [low, high] = std::ranges::minmax(sway_rad);
  const double reach = std::max(std::abs(static_cast<double>(low)), std::abs(static_cast<double>(high)));
  const double trained_rad =
      sim::sway_limit_rad * (1.0 + largest(trained, sim::Condition::gain)) + moved_deg * sim::rad_per_deg;
  if (reach > trained_rad && !trial.is_large)
    add_caution(estimate.warnings, "beyond_training",
                format("sway reaches %.1f degrees; trials beyond %g degrees were never trained on",
                       reach / sim::rad_per_deg, trained_rad / sim::rad_per_deg));
}

constexpr double against_ratio = -0.5;  // a response ratio of -1 is the other sign

/// Returns a hint if the response to fast tilts, which a body's inertia keeps small, is one to one: the sway is the
/// tilt itself, or an angle between body and platform. Empty otherwise.
std::string hint_of_reference(const Explanation& explanation) {
  constexpr double fast_hz = 1.3, near = 0.5, min_coherence = 0.5, same = 0.1;
  if (!explanation.frf || explanation.frf->recorded.empty()) return {};
  const auto distance = [](const sim::Complex& response, double from) {
    const double real = response.real() - from, imaginary = response.imag();
    return std::sqrt(real * real + imaginary * imaginary);
  };
  sim::Complex fast;
  double coherence = 0.0, bands = 0.0, from_tilt = 0.0, from_reversed = 0.0;
  for (const sim::FrfPoint& point : explanation.frf->recorded) {
    from_tilt = std::max(from_tilt, distance(point.response, 1.0));
    from_reversed = std::max(from_reversed, distance(point.response, -1.0));
    if (point.frequency_hz < fast_hz) continue;
    fast += point.response;
    coherence += point.coherence;
    bands += 1.0;
  }
  if (from_tilt < same || from_reversed < same)
    return "; this sway is the platform's tilt" + std::string(from_tilt < same ? "" : ", reversed") +
           ": name the column of the body's sway with " + setting("column");
  if (bands < 2.0 || !(coherence > min_coherence * bands)) return {};  // a coherence may be NaN
  fast /= bands;
  const bool is_angle = distance(fast, -1.0) < near;
  if (!is_angle && distance(fast, 1.0) >= near) return {};
  return format(
             "; above %g Hz the sway follows the tilt with a gain of %.2f, where a body in space hardly moves: it is "
             "an angle against the platform, as of an ankle, or of a camera on the platform; ",
             fast_hz, fast.real()) +
         (is_angle ? "add the tilt to it" : "subtract it, as decid reads it, from the tilt") +
         ", and give the result as sway";
}

/// Adds a warning to recordings that are out of distribution.
void judge(const Model& model, const Estimate& estimate, const recording::Trial& trial, Explanation& explanation) {
  if (!model.ood_detector.known()) {
    append(explanation.warnings, response_ratio_warnings(explanation));
    return;
  }
  explanation.ood_score = ood_score(estimate.distance, model.ood_detector.usual, explanation.response_ratio);
  if (explanation.ood_score <= 1.0) return;  // false for NaN
  const bool stands = std::isfinite(explanation.rms_residual_deg);
  const double noise = model.protocol.family().coefficients(estimate.parameters)[sim::Coefficient::nv];
  const std::string response = std::isnan(explanation.response_ratio)
                                   ? "no stimulus response ratio, because the identified controller " +
                                         std::string(stands && noise <= 0.0 ? "has no noise" : "falls")
                                   : format("stimulus response ratio %.2f", explanation.response_ratio);
  explanation.unlike_training = format(
      "this recording does not resemble the trials of the model's training (OOD score %.4g, limit 1; %s); common "
      "causes: wrong sign, late start, other platform movement, wrong unit or rate, smoothing",
      std::ceil(1e3 * explanation.ood_score) / 1e3, response.c_str());  // rounded up: never the limit itself
  const std::string hint = hint_of_reference(explanation);
  explanation.unlike_training += hint;
  if (hint.empty() && explanation.response_ratio < against_ratio && !trial.start_is_doubtful)
    explanation.unlike_training +=
        "; the sway goes against the platform: if its sensor is reversed, give " + setting("invert") + " sway";
  add_invalid(explanation.warnings, "out_of_distribution", explanation.unlike_training);
}

}  // namespace

Identifier::Identifier(const Model& model, ForBody body, std::size_t expected_at_once)
    : model_(model),
      body_(std::move(body)),
      explainer_(std::make_shared<const Explainer>(sim::Simulator(body_.protocol))),
      at_once_(static_cast<int>(std::clamp(expected_at_once, std::size_t{1}, max_at_once))),
      predictor_(model.network, at_once_) {}

Identifier::Identifier(const Identifier& other)
    : model_(other.model_),
      body_(other.body_),
      explainer_(other.explainer_),
      at_once_(other.at_once_),
      predictor_(other.predictor_.shared_inference(), at_once_) {}

Identifier::Trials Identifier::pointers(const std::vector<recording::Trial>& trials) {
  Trials all;
  for (const recording::Trial& trial : trials) all.push_back(&trial);
  return all;
}

std::vector<Estimate> Identifier::run(const Trials& trials) {
  const dataset::ImageMaker& maker = model_.images();
  const auto values = static_cast<std::size_t>(maker.shape().size());
  const auto outputs = static_cast<std::size_t>(model_.network.output_shape().size());
  const auto features = model_.ood_detector.known() ? static_cast<std::size_t>(predictor_.feature_count()) : 0;
  for (std::size_t i = 0; i < trials.size(); ++i)
    if (!std::ranges::all_of(trials[i]->sway_rad(), [](float value) { return std::isfinite(value); }))
      throw Error(Code::value_invalid, format("trial %zu", i), "has sway that is not finite",
                  "interpolate what is missing");
  std::vector<Estimate> all(trials.size());
  for (std::size_t first = 0; first < trials.size(); first += max_at_once) {
    const std::size_t count = std::min(max_at_once, trials.size() - first);
    std::vector<dataset::Sway> sways;
    for (std::size_t i = 0; i < count; ++i) sways.emplace_back(trials[first + i]->sway_rad(), body_.height);
    std::vector<float> images(count * values), output(count * outputs), feature(count * features);
    maker.make_all(sways, images);
    for (std::size_t i = 0; i < count; ++i) {
      const auto image = std::span(images).subspan(i * values, values);
      all[first + i].image.assign(image.begin(), image.end());
      model_.scale(image);
    }
    predictor_.run(images, output, feature);
    for (std::size_t i = 0; i < count; ++i) {
      Estimate& estimate = all[first + i];
      const auto own = std::span<const float>(output).subspan(i * outputs, outputs);
      estimate.parameters = body_.from_model(model_, model_.decode(own));
      estimate.distribution = model_.distribution(own, body_.ranges);
      if (features > 0)
        estimate.distance = model_.ood_detector.distance(std::span(feature).subspan(i * features, features));
      warn_of_model(model_, estimate);
      warn_of_ranges(body_.ranges, estimate);
      warn_of_sway(model_.protocol.conditions, *trials[first + i], estimate);
    }
  }
  return all;
}

std::vector<Explanation> Identifier::compare(std::span<const Estimate> estimates, const Trials& trials) const {
  std::vector<Answer> answers;
  for (std::size_t i = 0; i < estimates.size(); ++i) answers.push_back({estimates[i].parameters, *trials[i]});
  std::vector<Explanation> all = explainer_->explain(answers);
  for (std::size_t i = 0; i < all.size(); ++i) {
    judge(model_, estimates[i], *trials[i], all[i]);
    all[i].warnings = without_refused_lean(std::move(all[i].warnings));
  }
  return all;
}

void Identifier::identify(std::span<RecordingResult> read) {
  std::vector<RecordingResult*> usable;
  Trials trials;
  for (RecordingResult& result : read) {
    if (result.error) continue;
    usable.push_back(&result);
    trials.push_back(&result.trial);
  }
  std::vector<Estimate> estimates = run(trials);
  std::vector<Explanation> explanations = compare(estimates, trials);
  for (std::size_t i = 0; i < usable.size(); ++i) {
    RecordingResult& result = *usable[i];
    result.estimate = std::move(estimates[i]);
    result.explanation = std::move(explanations[i]);
    result.warnings = without_refused_lean(
        most_severe_first({result.warnings, result.estimate.warnings, result.explanation.warnings}));
  }
}

RecordingResult identify(const Model& model, std::span<const double> sway_rad, double rate_hz,
                         const IdentifyOptions& options, const std::optional<sim::Body>& body) {
  const bool mean_is_upright = options.detrend != recording::Detrend::none;
  RecordingResult result = bring(recording::make_recording(sway_rad, rate_hz, mean_is_upright),
                                 recording::ProtocolPlan(model.protocol), options, body);
  Identifier(model, for_body(model, "the model", body), 1).identify(std::span(&result, 1));
  return result;
}

}  // namespace decid
