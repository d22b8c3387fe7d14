// The size of a sway, which shows a wrong unit or column. Not installed.
#pragma once

#include "recording/recording.hpp"

namespace decid::recording {

/// Throws Error if the sway is too large for a standing body, and warns of suspicious sizes. `guessed`: its unit was
/// guessed. `mean_is_upright`: sizes count from the mean instead of 0. `of_positions`: the sway was computed from them.
void check_size(const Signal<double>& sway, bool guessed, bool mean_is_upright, bool of_positions,
                Recording& recording);

/// Throws Error with the problem of impossible values if reading has warned that the given unit is not the name's.
void refuse_differing_unit(const Recording& recording, const std::string& problem);

}  // namespace decid::recording
