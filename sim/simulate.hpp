// A trial: the single inverted pendulum on the tilting platform under the DEC controller, 1 ms semi-implicit Euler.
// Equations (a = body in space, f = platform in space, e = tilt estimate, all rad; u at t - delay, zero before):
//   e' = f_theta(f' + nu')                              dead band, eq. 2 and 3 of the paper
//   u  = Kp (2a + e - f) + Kd (2a' + e' - f')           servo signal e + a - f, plus gravity estimate 1 * a
//   J a'' = m g h sin(a) - u(t - delay) - Kp_pass (a - f) - Kd_pass (a' - f')
// These are the equations of the model `dec`; family.hpp has those of all models that the simulator works with.
// The paper's printed sum (eq. 7) omits the servo term, and its signs of the ankle angle are inconsistent. This code
// follows the paper's text, with the ankle angle = body - platform throughout. A body that has stood before the trial
// (Protocol::standing_s) begins at rest that much earlier, on a resting platform, or before one more cycle
// (Protocol::moved_before).
#pragma once

#include <functional>
#include <memory>
#include <span>

#include "base/math/random.hpp"
#include "sim/noise.hpp"
#include "sim/parameters.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::sim {

/// A trial is valid while the body stays within this bound, over every integration step.
inline constexpr double sway_limit_rad = 5.0 * rad_per_deg;
/// The longest delay that can be simulated.
inline constexpr double longest_delay_s = 1.0;

struct Outcome {
  bool valid;           ///< stayed within sway_limit_rad; for two segments, each also within segment_limit_rad
  double max_sway_rad;  ///< max |a| over these steps, standing included; infinite if not finite
  double end_s;  ///< its length, or the end of the sample period (DoubleSimulator: of the step) in which the body left
                 ///< the bound; 0 if it fell while it stood before the trial
  /// Returns the number of samples until then.
  std::size_t samples(double rate_hz) const;
};

/// The inputs of a trial in addition to the protocol. `noise` gives the vestibular noise's normals.
struct TrialInput {
  Parameters parameters;
  Random noise;
  double height = 1.0;  ///< body height relative to the protocol's (Body::of_height), 0.1 to 10
};

/// Simulates trials of one protocol. Immutable: all threads may share it. Many trials run in parallel in the lanes of
/// vector registers; a trial that ends gives its lane to the next. Each lane is one chain of fused multiply-adds in a
/// fixed order. A trial therefore has the same bits with any other trials, instruction set and number of threads.
class Simulator {
 public:
  /// Throws Error if the protocol is invalid. isa: tests and benchmarks may choose another.
  explicit Simulator(Protocol protocol, Isa isa = chosen_isa());

  const Protocol& protocol() const noexcept;
  const Stimulus& stimulus() const noexcept;
  int samples() const noexcept;

  /// Simulates one trial, from rest, upright, or after the protocol's standing. sway_rad: samples() values, sample k at
  /// t = k / rate; values after the body leaves the bound are not written. `noise` gives the vestibular noise's
  /// normals. Adds no measurement noise. Throws Error for a non-finite or negative parameter, a delay above
  /// longest_delay_s, or a span of another length.
  Outcome run(const Parameters& parameters, const Random& noise, std::span<double> sway_rad) const;

  /// Makes trial `index`; any thread may call it.
  using TrialOf = std::function<TrialInput(int index)>;
  /// Receives each trial once, in any order and from any thread; sway_rad may be changed and is valid only during the
  /// call.
  using Finished = std::function<void(int index, const Outcome& outcome, std::span<double> sway_rad)>;
  /// Simulates make_trial(0) .. make_trial(count - 1) on OpenMP's threads, with the bits of run(). Larger calls fill
  /// the lanes better: give hundreds of trials. Throws the errors of run(), make_trial and finished.
  void run_all(int count, const TrialOf& make_trial, const Finished& finished) const;

  /// Makes an attempt at trial `index`: 0, 1, ...
  using AttemptOf = std::function<TrialInput(int index, int attempt)>;
  /// Receives the valid attempt, as Finished does.
  using Valid = std::function<void(int index, const TrialInput& trial, std::span<double> sway_rad)>;
  /// Simulates like run_all(), repeating each index until its trial is valid; calls finished only for that one. Also
  /// throws Error if `attempts` consecutive trials are invalid.
  void run_until_valid(int count, int attempts, const AttemptOf& make_trial, const Valid& finished) const;

 private:
  struct Core;
  std::shared_ptr<Core> core_;  // shared by copies
};

/// Returns the closed loop's transfer function from platform tilt to body sway at theta = 0, no noise, small angles,
/// for the experiment's body and member of the family (family.hpp), s = 2 pi i f:
///   H(s) = (passive + L (position - tilt)) / (J s^2 - m g h + L (position + gravity + Q) + passive),
///   passive = kp_pass + s kd_pass,  L = P / (1 - P R),  P = (kp + s kd) exp(-s delay),
///   Q = slow / (s + 1 / slow_time),  R = torque / (m g h) / (s + 1 / torque_time).
Complex closed_loop(const Experiment& experiment, const Parameters& parameters, double frequency_hz);

}  // namespace decid::sim
