// A body that an exported controller balances, in steps of any length: the trial of the controller's self-test.
#pragma once

#include <array>
#include <vector>

#include "sim/simulate.hpp"

namespace decid::tools {

/// Returns a stimulus for steps of another length: in intervals of a whole number of them, about 10 ms, each with the
/// tilt's mean rate. Its last point is the last interval's start.
sim::Stimulus stimulus_at(const sim::Stimulus& stimulus, int steps_per_second);

/// Returns sim::sine_coefficients_for the body, for another step.
std::array<double, 3> sine_coefficients_at(const sim::Body& body, int steps_per_second);

/// A body on the platform.
struct Balanced {
  std::vector<double> sway;            ///< rad, at the start of each interval, until it leaves the simulator's bound
  double peak_active_torque_nm = 0.0;  ///< the largest of a step, in size, until then
};

/// Simulates the body, noise-free and from rest. The operations are those of DECID_FW_self_test in
/// runtime/controller.c. UNIT_GAINS there only moves factors of 2, so at 1000 steps per second this sway has the
/// simulator's bits.
Balanced balance(const sim::Family& family, const sim::Coefficients& of, const sim::Body& body,
                 const sim::Stimulus& stimulus, int steps_per_second);

}  // namespace decid::tools
