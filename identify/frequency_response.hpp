// Frequency responses of an identification: the recording's beside the identified controller's.
#pragma once

#include "identify/identification.hpp"

namespace decid {

/// Analyses the recording and the trial simulated from its parameters; needs sway_rad, tilt_rad and fitted_rad. Of
/// three cycles and more the first is left out, with the transient from rest. Where the stimulus has no frequency
/// response it leaves frf empty and adds a warning; it also warns if as much response as was found comes about by
/// chance in more than one of 100 recordings without any.
void add_frequency_response(Identification& id);

}  // namespace decid
