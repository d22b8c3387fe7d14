// Finds a cycle that was copied: programs that average a trial's cycles write the mean as often as a reader needs it.
// Not installed.
#pragma once

#include <span>

#include "base/warning.hpp"
#include "recording/trial.hpp"

namespace decid::recording {

/// Returns the caution `repeated_cycle` if the second cycle of a sway in rad repeats the first one within 1e-5 degrees:
/// in all of its first 5 s, and in 98% of the other samples; else nothing. from_hz: the recording's rate. If the sway
/// was resampled, as many samples of the start may differ as the filter reaches.
/// A body without noise also repeats its cycles once it has settled. If it began at rest, the start differs. A body
/// without noise that swayed for a cycle before the first sample is taken for a copy. So is a start from rest that the
/// file's digits hide: steps of 0.1 degrees, or steps of 0.01 degrees with tilts slower than 0.002 Hz.
/// Ignores protocols of one cycle, a sway that stands still except for 1% of its samples at either side, and a sway
/// that follows the prescribed tilt, or its reverse, with a correlation above 0.99: it is the tilt. The sway is at the
/// protocol's samples.
Warnings look_for_repeated_cycle(std::span<const double> sway_rad, const ProtocolPlan& plan, double from_hz);

}  // namespace decid::recording
