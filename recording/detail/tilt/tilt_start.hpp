// The protocol's start by the measured tilt of the platform. Not installed.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "recording/recording.hpp"
#include "recording/trial.hpp"

namespace decid::recording {

/// A smaller correlation of the measured tilt with the prescribed one is cautioned (`tilt_follows_roughly`).
inline constexpr double good_correlation = 0.95;
/// The allowed difference of the measured size from the prescribed one, as a fraction.
inline constexpr double good_gain = 0.1;

/// Returns the protocol's tilt in rad, one value per sample.
std::vector<double> prescribed_tilt(const sim::Protocol& protocol);

/// Returns the number of a protocol's samples that may lie beyond the ends of a measured tilt. It exceeds the allowed
/// number, so that missing samples are reported instead of overlooked.
std::size_t overhang_of(std::size_t samples);

/// Finds the protocol's tilt in the recording's. Throws Error if the platform played another stimulus, and for too few
/// samples; adds warnings of what differs.
TiltMatch find_start(const ProtocolPlan& plan, double from_hz, Recording& recording);

/// Compares a tilt that was found by its name or its values with the protocol at the start that was given: adds the
/// warnings of find_start(). If it does not follow the protocol there, removes it, with a warning, and returns nothing.
std::optional<TiltMatch> check_at_start(const ProtocolPlan& plan, double from_hz, double start_s, Recording& recording);

/// Tries a tilt that was found by its name or its values. If it does not follow the protocol, nothing else is known
/// about the stimulus: removes it, with a warning.
std::optional<TiltMatch> try_start(const ProtocolPlan& plan, double from_hz, Recording& recording);

}  // namespace decid::recording
