// Subtracts the offset and drift of a trial. Not installed.
#pragma once

#include <vector>

#include "base/warning.hpp"
#include "recording/trial.hpp"

namespace decid::recording {

/// Subtracts what `kind` names from a trial's sway (see Detrend), and says how much in a note.
void detrend(std::vector<double>& sway, const sim::Protocol& protocol, Detrend kind, Warnings& warnings);

}  // namespace decid::recording
