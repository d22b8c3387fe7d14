// Finds a sway whose samples are in the reverse order of time: it responds to the tilt only backwards. Not installed.
#pragma once

#include <span>

#include "base/warning.hpp"
#include "recording/trial.hpp"

namespace decid::recording {

/// Returns `time_reversed`, invalid, if the linear response to the tilt (response_check.hpp) of the reversed sway
/// improves its fit by 30 and 1.5 times as much as the response of the sway itself, started up to 3 s before or after
/// the protocol; else nothing. Ignores trials under 40 s, and tilts that explain their own reverse, as a sum of few
/// sines does. The sway is at the protocol's samples, in rad.
Warnings look_for_reversed_time(std::span<const double> sway_rad, const ProtocolPlan& plan);

}  // namespace decid::recording
