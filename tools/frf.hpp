// Frequency responses of an identification, as JSON and as figures that people read off a Bode diagram.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "tools/identification.hpp"

namespace decid::tools {

/// Analyses the recording and the trial simulated from its parameters; needs sway_rad, tilt_rad and fitted_rad. Of
/// three cycles and more the first is left out, with the transient from rest. Where the stimulus has no frequency
/// response it leaves frf empty and adds a warning; it also warns if as much response as was found comes about by
/// chance in more than one of 100 recordings without any.
void add_frequency_response(Identification& id);

/// Gain and phase with the limits of the 95% circle about the response: gain -+ radius (not below 0), phase -+
/// asin(radius / gain). NaN where the circle is unknown, and for a phase's limits where it holds the origin.
struct Bode {
  double gain, gain_low, gain_high;
  double phase_deg, phase_low_deg, phase_high_deg;
};
/// near_deg: the phase is given within 180 degrees of it.
Bode bode(const sim::FrfPoint& point, double near_deg);

/// Arrays, an entry a band; null where a figure is not known.
nlohmann::ordered_json frf_to_json(const FrequencyResponses& frf);

}  // namespace decid::tools
