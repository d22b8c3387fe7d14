// Classifies the platform's movement before the protocol's start by its measured tilt. Not installed.
#pragma once

#include <span>
#include <vector>

namespace decid::recording {

enum class TiltBefore {
  unknown,  ///< the tilt begins less than 1 s before
  at_rest,
  cycle_end,     ///< the platform played the end of the protocol's last cycle
  another_tilt,  ///< the platform moved differently
};

/// Classifies the movement. `measured`: the tilt at the protocol's rate. `start`: the sample of it at which the
/// protocol starts. `expected`: the protocol's tilt. `gain`: measured over expected tilt.
TiltBefore tilt_before(std::span<const double> measured, double start, std::span<const double> expected, double gain,
                       double rate_hz);

}  // namespace decid::recording
