// Many single pendulums in parallel: the memory of the kernels, and their common arithmetic. Equations: simulate.hpp.
// Constants that multiply the same quantity are joined before the first step. With e = (estimate - platform) / 2 and q
// = e' the platform's own motion cancels in the servo signal:
//   q  = (nu' - clamp(f' + nu', -theta, theta)) / 2
//   u  = 2 Kp (a + e) + 2 Kd (a' + q)
//   a' = a z P(z) + (k1 a + (k2 a' + (drive - delayed u))),  z = a^2
//   a  = a + step a',  e = e + step q
// where a z P(z) = c m g h (sin a - a), k1 = c (m g h - Kp_pass), k2 = 1 - c Kd_pass, c = step / J, gains are
// multiplied by c, and drive = Kp_pass f + Kd_pass f'. A product and the sum it is added to are one fused multiply-add,
// outermost last. nu' and drive are linear: they change by a constant from step to step.
//
// Members of the family with other gains (StepConstants::unit_gains false, family.hpp) keep v = (servo + gravity) a + e
// - servo f + slow + torque as it is:
//   q  = tilt (nu' - clamp(f' + nu', -theta, theta)) + (tilt - servo) f'
//   u  = Kp (reach a + e + x + y) + Kd (reach a' + q + x' + y'),  reach = servo + gravity
//   x' = slow a - leak_x x,  y' = torque u_1 - leak_y y,  u_1 the delayed command of the step before
// With a dead band b before the gravity gain, v loses gravity clamp(a, -b, b), and v' loses gravity a' while |a| < b.
#pragma once

#include <cstddef>

namespace decid::sim {

/// Constants of all trials.
struct StepConstants {
  double step_s;
  double per_step;       ///< 1 / steps_per_sample
  int steps_per_sample;  ///< divided by interval_steps without remainder
  int interval_steps;    ///< of the stimulus
  double sway_limit_rad;
  bool unit_gains;                ///< of all trials: Family::has_unit_gains, and no dead band
  double slow_leak, torque_leak;  ///< step / slow_time and step / torque_time of the family
  double gravity_dead_band;       ///< rad; 0: none
};

/// `count` trials, one per lane, each at its own time.
struct Pendulums {
  // 2 registers of 8 lanes. Three or four were no faster: loads limit a step, not latency.
  static constexpr int count = 16;
  /// The past commands that a lane may need, and those of the current run, a row of `count` each.
  static constexpr int longest_lag = 1000, rows = longest_lag + 1024;

  // Constants of the lanes' trials.
  alignas(64) double kp[count];       // 2 c Kp
  alignas(64) double kd[count];       // 2 c Kd
  alignas(64) double passive[count];  // c Kp_pass
  alignas(64) double damping[count];  // c Kd_pass
  alignas(64) double k1[count], k2[count];
  alignas(64) double sine[3][count];                    // c m g h times the coefficients of P, lowest first
  alignas(64) double theta[count], minus_theta[count];  // half of the threshold
  alignas(64) double fraction[count];                   // of the delay, in steps, beyond a whole number
  // Members without unit gains; kp, kd are c times the gains there, and theta, noise are multiplied by `tilt`.
  alignas(64) double reach[count];            // servo + gravity
  alignas(64) double tilt[count];             // gain of the tilt estimate
  alignas(64) double tilt_over_servo[count];  // tilt - servo
  alignas(64) double slow_gain[count], torque_gain[count];
  alignas(64) double minus_gravity[count];  // -gravity; read only with a dead band
  // Their state.
  alignas(64) double sway[count], sway_rate[count];
  alignas(64) double error[count];     // e
  alignas(64) double newer[count];     // the delayed command of the previous step
  alignas(64) double noise[count];     // nu' / 2 at the start of the current sample
  alignas(64) double max_sway[count];  // max |a|
  // Members without unit gains: slow feedback and torque feedback, and the delayed command of the step before.
  alignas(64) double slow[count], torque[count], active[count];
  // Addresses of each lane's next reads and writes.
  /// Distance between a trial's noise values of consecutive samples: noises of trials are interleaved.
  static constexpr int noise_apart = 8;
  const double* noise_rate[count];  // [noise_apart] is nu' at the end of the current sample
  const double* stimulus[count];    // tilt and rate of each interval
  double* samples[count];
  const double* delayed[count];  // [row * count]: the command a whole number of steps before that row
  // A lane's active torque is zero until its delay has passed, whatever its column held before.
  alignas(64) double first_row[count];
  int lanes;  ///< lanes from here on are at rest and need no steps
  int last_first_row;
  int row;  // of the next command
  alignas(64) double commands[static_cast<std::size_t>(rows) * count];
};

/// Advances all lanes by up to `samples` samples; stops after a sample in which a lane left the bound. Returns the
/// number of samples. The caller advances pointers and `row` by it.
using AdvancePendulums = int (*)(Pendulums& pendulums, const StepConstants& step_constants, int samples);

}  // namespace decid::sim
