// Finds a person who leans slowly to and fro, which neither the tilt nor the noise of a trained body explains. Not
// installed.
#pragma once

#include <span>

#include "base/warning.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::recording {

/// Adds `slow_lean`, a caution, if the first two cycles of a sway in rad differ slowly by 0.6 degrees rms: in the first
/// and second harmonic of the difference, without its mean, over the square root of 2. A drift of the sensor cancels.
/// Checks only sequences of the default vestibular noise, up to 2 degrees of tilt, whose cycles last 40 s or longer:
/// there it was measured. The sway is at the protocol's rate.
void look_for_slow_lean(std::span<const double> sway_rad, const sim::Protocol& protocol, Warnings& warnings);

}  // namespace decid::recording
