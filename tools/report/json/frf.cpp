// Frequency responses of an identification: see frf.hpp.
#include "tools/report/json/frf.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/files/json_object.hpp"
#include "tools/report/json/parameters_json.hpp"

namespace decid::tools {
namespace {

double angle_near(double angle_deg, double near_deg) {
  return angle_deg + 360.0 * std::round((near_deg - angle_deg) / 360.0);
}

double phase_near(sim::Complex response, double near_deg) {
  return angle_near(std::arg(response) / sim::rad_per_deg, near_deg);
}

/// Returns the responses of the controller that predicts best; of the first one that has some if that has none.
const CheckedResponses& best_responses(const FitFigures& fitted) {
  const CheckedResponses* found = &fitted.check.responses;
  for (const ControllerFit& other : fitted.others) {
    const CheckedResponses& responses = other.check.responses;
    if (responses.recorded.empty()) continue;
    if (found->recorded.empty() || other.compared.difference == 0.0) found = &responses;
  }
  return *found;
}

}  // namespace

Bode bode(const sim::FrfPoint& point, double near_deg) {
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  const double gain = std::abs(point.response), phase = phase_near(point.response, near_deg);
  const double swing = point.radius < gain ? std::asin(point.radius / gain) / sim::rad_per_deg : unknown;
  const double low = std::isnan(point.radius) ? unknown : std::max(0.0, gain - point.radius);
  return {gain, low, gain + point.radius, phase, phase - swing, phase + swing};
}

Json frf_to_json(const FrequencyResponses& frf) {
  Json json{{"cycles", frf.cycles}, {"confidence", 0.95}};
  const char* const keys[] = {
      "frequency_hz",   "harmonics", "gain",       "gain_low",        "gain_high",   "phase_deg",       "phase_low_deg",
      "phase_high_deg", "coherence", "model_gain", "model_phase_deg", "linear_gain", "linear_phase_deg"};
  for (const char* key : keys) json[key] = Json::array();
  double linear_deg = 0.0;  // unwrapped from band to band; all other phases are given near it
  for (std::size_t i = 0; i < frf.recorded.size(); ++i) {
    const sim::FrfPoint& point = frf.recorded[i];
    linear_deg = phase_near(frf.linear[i], linear_deg);
    const Bode shown = bode(point, linear_deg);
    const bool stands = i < frf.model.size();
    json["frequency_hz"].push_back(page_number(point.frequency_hz));
    json["harmonics"].push_back(point.harmonics);
    json["gain"].push_back(page_number(shown.gain));
    json["gain_low"].push_back(page_number(shown.gain_low));
    json["gain_high"].push_back(page_number(shown.gain_high));
    json["phase_deg"].push_back(page_number(shown.phase_deg));
    json["phase_low_deg"].push_back(page_number(shown.phase_low_deg));
    json["phase_high_deg"].push_back(page_number(shown.phase_high_deg));
    json["coherence"].push_back(page_number(point.coherence));
    json["model_gain"].push_back(stands ? page_number(std::abs(frf.model[i].response)) : Json(nullptr));
    json["model_phase_deg"].push_back(stands ? page_number(phase_near(frf.model[i].response, linear_deg))
                                             : Json(nullptr));
    json["linear_gain"].push_back(page_number(std::abs(frf.linear[i])));
    json["linear_phase_deg"].push_back(page_number(linear_deg));
  }
  return json;
}

ControllerResponse controller_response(const FitFigures& fitted, const PredictiveCheck& check) {
  ControllerResponse made;
  const CheckedResponses& responses = check.responses;
  if (responses.recorded.empty()) return made;
  made.simulated_gain = responses.gain;
  const std::vector<double>& best_rad = best_responses(fitted).phase_rad.middle;
  double best_deg = 0.0;  // unwrapped from band to band
  for (std::size_t i = 0; i < responses.recorded.size(); ++i) {
    const sim::FrfPoint& point = responses.recorded[i];
    best_deg = angle_near(best_rad[i] / sim::rad_per_deg, best_deg);
    made.frequency_hz.push_back(point.frequency_hz);
    made.gain.push_back(std::abs(point.response));
    made.phase_deg.push_back(phase_near(point.response, best_deg));
    const double middle_deg = responses.phase_rad.middle[i] / sim::rad_per_deg,
                 turns_deg = angle_near(middle_deg, made.phase_deg.back()) - middle_deg;
    made.simulated_phase_deg.low.push_back(responses.phase_rad.low[i] / sim::rad_per_deg + turns_deg);
    made.simulated_phase_deg.middle.push_back(middle_deg + turns_deg);
    made.simulated_phase_deg.high.push_back(responses.phase_rad.high[i] / sim::rad_per_deg + turns_deg);
  }
  return made;
}

}  // namespace decid::tools
