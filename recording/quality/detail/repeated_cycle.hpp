// Finds a cycle that was copied: programs that average a trial's cycles write the mean as often as a reader needs it.
// Not installed.
#pragma once

#include <span>

#include "base/warning.hpp"
#include "sim/protocol/experiment.hpp"

namespace decid::recording {

/// Adds `repeated_cycle`, a caution, if the second cycle of a sway in rad repeats the first one within 1e-5 degrees in
/// 98% of its samples. A body at rest differs in its first seconds, also without noise. Ignores a sway that stands
/// still, and protocols of one cycle. The sway is at the protocol's rate.
void look_for_repeated_cycle(std::span<const double> sway_rad, const sim::Experiment& experiment, Warnings& warnings);

}  // namespace decid::recording
