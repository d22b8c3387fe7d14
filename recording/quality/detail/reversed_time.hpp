// Finds a sway whose samples are in the reverse order of time: it responds to the tilt only backwards. Not installed.
#pragma once

#include <span>

#include "base/warning.hpp"
#include "recording/trial.hpp"

namespace decid::recording {

/// Returns `time_reversed`, invalid, if the tilt improves the prediction of the reversed sway
/// (prediction.hpp) by 30 and twice as much as that of the sway itself, started up to 3 s before or
/// after the protocol; else nothing. Ignores trials under 40 s. The sway is at the protocol's samples, in rad;
/// response_gain: the sway's.
Warnings look_for_reversed_time(std::span<const double> sway_rad, double response_gain, const ProtocolPlan& plan);

}  // namespace decid::recording
