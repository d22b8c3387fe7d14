// An experiment is data: the platform's motion, the sampling of the sway, and the body on the platform. Body: Winter,
// Biomechanics and Motor Control of Human Movement, table of anthropometric data.
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

  /// Returns the gravitational stiffness m g h in N m/rad; 838.98 by default.
  double mgh() const { return mass_kg * gravity * com_height_m; }
  /// Returns a body of the same build with the height scaled by `factor`, and a mass that keeps m g h: for given
  /// parameters over m g h only its inertia differs.
  Body of_height(double factor) const { return {mass_kg / factor, com_height_m * factor, inertia_kgm2 * factor}; }
  /// Returns the height ratio to `other`, for bodies of the same build: the ratio of J / (m g h).
  double height_over(const Body& other) const { return inertia_kgm2 / mgh() / (other.inertia_kgm2 / other.mgh()); }

  friend bool operator==(const Body&, const Body&) = default;
};

/// Trials of equal experiments are comparable: they differ only in controller and noise.
struct Experiment {
  StimulusKind stimulus = Sequence{};
  double sample_rate_hz = 100.0;  ///< of the sway; divides 1000
  Body body;
  const BodyModel* body_model = &single_pendulum();  ///< of body and controller; must outlive the experiment

  const ParameterTable& parameters() const { return body_model->parameters; }
  const Family& family() const { return body_model->family; }

  /// Throws Error naming the protocol and the setting if any is out of its bounds, or if the number of samples has a
  /// prime factor above max_fft_prime (sim/fft.hpp). All other functions assume a valid experiment.
  void validate(const std::string& protocol) const;
  /// Throws Error for settings that can be simulated but are not an experiment: a body with less inertia about the
  /// ankles than its mass at its centre (parallel axis theorem; 1e-6 of it is rounding), and a measured tilt whose
  /// cycles do not join.
  void refuse_implausible(const std::string& protocol) const;

  // Functions for all kinds of stimulus. For a sequence they compute the lengths at each call: keep them out of inner
  // loops.

  int cycles() const;
  double lead_in_s() const;
  /// Returns the length of one cycle of the stimulus in s.
  double cycle_s() const;
  /// Returns the length of a trial in 1 ms steps.
  int steps() const;
  int steps_per_sample() const;
  /// Returns the samples of a trial: sample k at t = k / sample_rate_hz, k = 0 .. samples() - 1.
  int samples() const;
  double duration_s() const;

  friend bool operator==(const Experiment&, const Experiment&) = default;
  /// Returns true if the experiments differ at most in the body.
  bool is_same_but_body(const Experiment& other) const {
    return stimulus == other.stimulus && sample_rate_hz == other.sample_rate_hz && body_model == other.body_model;
  }
};

/// Returns the tilt of a valid experiment. A ternary sequence's tilt is a whole number of states times one factor, so
/// it does not drift. Its grid is the widest with a point at every change of the velocity. All other kinds use the
/// samples' grid.
Stimulus make_stimulus(const Experiment& experiment);

/// Returns the tilt in rad at the samples of a trial; stimulus: the experiment's.
std::vector<double> tilt_at_samples(const Experiment& experiment, const Stimulus& stimulus);

}  // namespace decid::sim
