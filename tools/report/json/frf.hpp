// Frequency responses of an identification, as JSON and as figures that people read off a Bode diagram.
#pragma once

#include <vector>

#include "base/files/json.hpp"
#include "identify/result.hpp"

namespace decid::tools {

/// Gain and phase with the limits of the 95% circle about the response: gain -+ radius (not below 0), phase -+
/// asin(radius / gain). The limits are NaN where the circle is unknown; the phase's limits also where the circle
/// contains the origin.
struct Bode {
  double gain, gain_low, gain_high;
  double phase_deg, phase_low_deg, phase_high_deg;
};
/// Returns the figures of a point, with the phase within 180 degrees of near_deg.
Bode bode(const sim::FrfPoint& point, double near_deg);

/// Arrays, one entry per band; null where a figure is not known.
Json frf_to_json(const FrequencyResponses& frf);

/// A recorded response, and the 90% band and the median of a controller's simulated trials, band by band.
struct ControllerResponse {
  std::vector<double> frequency_hz, gain, phase_deg;
  posterior::Band simulated_gain, simulated_phase_deg;
};
/// Returns the responses of one of the fitted controllers. The recorded phases are near those of the controller that
/// predicts best, and so the same for all; the simulated ones are near the recorded. Empty if there is no response.
ControllerResponse controller_response(const FitFigures& fitted, const PredictiveCheck& check);

}  // namespace decid::tools
