// The DEC controller as C files for a firmware, with parameters that were identified or chosen.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "posterior/frf/stability.hpp"
#include "sim/simulate.hpp"
#include "tools/firmware/text.hpp"

namespace decid::tools {

/// Returns FNV-1a over the bits of values, a word at a time: hash_of in runtime/controller.c.
std::uint64_t hash_values(std::span<const double> values);

/// Returns the number of steps per second. Throws Error for a step outside of 0.0005 to 0.01 s, and unless the number
/// is whole.
int steps_per_second_of(double step_s);

/// How far a controller with its body is from falling, and the torque that it needs.
struct ControllerLimits {
  frf::StabilityMargins margins;  ///< of the loop with a step's delay
  // In the protocol's whole trial, noise-free:
  double peak_tilt_rad = 0.0, peak_sway_rad = 0.0;
  double peak_active_torque_nm = 0.0;
};

struct ControllerFiles {
  FirmwareFiles files;
  ControllerLimits limits;
};

/// Simulates the self-test's trial, noise-free, with the protocol's body and tilt: at the simulator's 1000 steps per
/// second, and with the controller's steps if they differ. The header states the limits. Throws Error if the body falls
/// with these parameters before the protocol ends, or if they cannot be simulated.
ControllerFiles controller_files(const sim::Parameters& parameters, const sim::Protocol& protocol,
                                 const std::string& name, const std::string& origin,
                                 int steps_per_second = sim::steps_per_second);

/// Returns the limits as sentences for people: a line for the margins and one for the torque.
std::vector<std::string> limits_text(const ControllerLimits& limits);

}  // namespace decid::tools
