// Many single pendulums side by side: the memory that the kernels work on, and the arithmetic that all of them follow.
// Equations: simulate.hpp. Constants that multiply the same quantity are joined before the first step, and with e =
// (estimate - platform) / 2 and q = e' the platform's own motion drops out of the servo signal:
//   q  = (nu' - clamp(f' + nu', -theta, theta)) / 2
//   u  = 2 Kp (a + e) + 2 Kd (a' + q)
//   a' = a z P(z) + (k1 a + (k2 a' + (drive - delayed u))),  z = a^2
//   a  = a + step a',  e = e + step q
// where a z P(z) = c m g h (sin a - a), k1 = c (m g h - Kp_pass), k2 = 1 - c Kd_pass, c = step / J, gains are taken
// times c, and drive = Kp_pass f + Kd_pass f'. A product and the sum it goes to are one fused multiply-add, outermost
// last. nu' and drive are linear: they grow by a constant from step to step.
#pragma once

#include <cstddef>

namespace decid::sim {

/// What does not change from trial to trial.
struct StepConstants {
  double step_s;
  double per_step;       ///< 1 / steps_per_sample
  int steps_per_sample;  ///< divided by interval_steps without remainder
  int interval_steps;    ///< of the stimulus
  double sway_limit_rad;
};

/// `count` trials, one a lane, each at its own time.
struct Pendulums {
  // 2 registers of 8 lanes. Three or four were no faster: loads limit a step, not latency.
  static constexpr int count = 16;
  /// Past commands that a lane may look back at, and those of the present run, a row of `count` each.
  static constexpr int longest_lag = 1000, rows = longest_lag + 1024;

  // Constants of the lanes' trials.
  alignas(64) double kp[count];       // 2 c Kp
  alignas(64) double kd[count];       // 2 c Kd
  alignas(64) double passive[count];  // c Kp_pass
  alignas(64) double damping[count];  // c Kd_pass
  alignas(64) double k1[count], k2[count];
  alignas(64) double sine[3][count];                    // c m g h times the coefficients of P, lowest first
  alignas(64) double theta[count], minus_theta[count];  // half of it
  alignas(64) double fraction[count];                   // of the delay, in steps, beyond a whole number of them
  // Their state.
  alignas(64) double sway[count], sway_rate[count];
  alignas(64) double error[count];    // e
  alignas(64) double newer[count];    // the delayed command of the step before
  alignas(64) double noise[count];    // nu' / 2 at the sample that begins
  alignas(64) double largest[count];  // max |a|
  // Where each lane reads and writes next.
  static constexpr int noise_apart = 8;  ///< from a sample's noise to the next: trials' noises lie side by side
  const double* noise_rate[count];       // [noise_apart] is nu' at the end of the sample that begins
  const double* stimulus[count];         // tilt and rate of each interval
  double* samples[count];
  const double* delayed[count];  // [row * count]: what was commanded a whole number of steps before that row
  // Before its delay has passed a lane's active torque is zero, whatever its column held before.
  alignas(64) double first_row[count];
  int lanes;  ///< those from here on are at rest, and need no step
  int last_first_row;
  int row;  // of the command that is next
  alignas(64) double commands[static_cast<std::size_t>(rows) * count];
};

/// Advances all lanes by up to `samples` samples; stops after a sample in which one of them left the bound. Returns how
/// many were done. The caller moves pointers and `row` on by that many.
using AdvancePendulums = int (*)(Pendulums& pendulums, const StepConstants& step_constants, int samples);

}  // namespace decid::sim
