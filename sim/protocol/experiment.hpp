// An experiment is data: what the platform plays, how the sway is sampled, whose body stands on the platform.
// Body: Winter, Biomechanics and Motor Control of Human Movement, table of anthropometric data.
#pragma once

#include <string>

#include "sim/body_model.hpp"
#include "sim/protocol/stimulus.hpp"

namespace decid::sim {

inline constexpr double pi = 3.14159265358979323846;
inline constexpr double rad_per_deg = pi / 180.0;
inline constexpr double gravity = 9.81;        ///< m/s^2
inline constexpr int steps_per_second = 1000;  ///< the fixed integration step is 1 ms
inline constexpr double integration_step_s = 1.0 / steps_per_second;

/// The body above the ankle as a single inverted pendulum. Defaults: Winter's segments for 88.86 kg and 1.80 m.
struct Body {
  double mass_kg = 86.283;
  double com_height_m = 0.99119;
  double inertia_kgm2 = 101.895;  ///< about the ankle

  /// Gravitational stiffness m g h in N m/rad; 838.98 by default.
  double mgh() const { return mass_kg * gravity * com_height_m; }
  /// A body of the same build so many times as tall, and lighter or heavier, so that m g h is the same: what parameters
  /// over m g h do to it differs by its inertia alone.
  Body of_height(double factor) const { return {mass_kg / factor, com_height_m * factor, inertia_kgm2 * factor}; }
  /// So many times as tall as the other, if both are of one build: the ratio of J / (m g h).
  double height_over(const Body& other) const { return inertia_kgm2 / mgh() / (other.inertia_kgm2 / other.mgh()); }

  friend bool operator==(const Body&, const Body&) = default;
};

/// Two trials of equal experiments can be compared: they differ in controller and noise alone.
struct Experiment {
  StimulusKind stimulus = Sequence{};
  double sample_rate_hz = 100.0;  ///< of the sway; divides 1000
  Body body;
  const BodyModel* body_model = &single_pendulum();  ///< of body and controller; outlives the experiment

  const ParameterTable& parameters() const { return body_model->parameters; }

  /// Throws Error naming the protocol and the setting if any is out of its bounds, or if the number of samples has a
  /// prime factor above max_fft_prime (sim/fft.hpp); all that follows assumes a valid experiment.
  void validate(const std::string& protocol) const;
  /// Throws Error likewise for what can be simulated but is no experiment: a body that has less inertia about the
  /// ankles than its mass at its centre (parallel axis theorem; 1e-6 of it are rounding), a measured tilt whose cycles
  /// do not join.
  void refuse_implausible(const std::string& protocol) const;

  // What all kinds of stimulus have. Of a sequence the lengths are counted anew at each call: keep them out of inner
  // loops.

  int cycles() const;
  double lead_in_s() const;
  /// Length of one cycle of the stimulus in s.
  double cycle_s() const;
  /// Length of a trial in 1 ms steps.
  int steps() const;
  int steps_per_sample() const;
  /// Samples of a trial: sample k at t = k / sample_rate_hz, k = 0 .. samples() - 1.
  int samples() const;
  double duration_s() const;

  friend bool operator==(const Experiment&, const Experiment&) = default;
};

/// The tilt of a valid experiment. A ternary sequence's is a whole number of states times one factor, so that it does
/// not drift; its grid is the widest with a point at every change of the velocity. The grid of all other kinds is that
/// of the samples.
Stimulus make_stimulus(const Experiment& experiment);

}  // namespace decid::sim
