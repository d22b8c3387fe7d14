// A protocol is data: everything about an experiment but the seven parameters. What the platform plays, how the
// sway is sampled, whose body stands on it, which noise disturbs it.
// Body: Winter, Biomechanics and Motor Control of Human Movement, table of anthropometric data.
#pragma once

#include <string>

#include "sim/stimulus.hpp"

namespace decid::sim {

inline constexpr double pi = 3.14159265358979323846;
inline constexpr double rad_per_deg = pi / 180.0;
inline constexpr double gravity = 9.81;        ///< m/s^2
inline constexpr int steps_per_second = 1000;  ///< the fixed integration step is 1 ms

/// The body above the ankle as a single inverted pendulum. Defaults: Winter's segments for 88.86 kg and 1.80 m.
struct Body {
  double mass_kg = 86.283;
  double com_height_m = 0.99119;
  double inertia_kgm2 = 101.895;  ///< about the ankle

  /// Gravitational stiffness m g h in N m/rad; 838.98 by default.
  double mgh() const { return mass_kg * gravity * com_height_m; }

  friend bool operator==(const Body&, const Body&) = default;
};

/// Gaussian noise of the vestibular channel: one-sided PSD(f) = (Nv * scale)^2 / f^exponent between low and high,
/// zero outside.
struct VestibularNoise {
  double scale_deg = 0.2;
  double low_hz = 1.0 / 121.0;
  double high_hz = 1.0;
  double exponent = 1.0;
};

/// White noise of the sway sensor, standard deviation in degrees, drawn log-uniform from [low, high] for each trial;
/// 0 and 0: none.
struct SensorNoise {
  double low_deg = 0.0;
  double high_deg = 0.0;
};

struct Protocol {
  std::string name = "default";
  StimulusKind stimulus = Sequence{};
  double sample_rate_hz = 100.0;  ///< of the sway; divides 1000
  Body body;
  VestibularNoise vestibular_noise;
  SensorNoise sensor_noise;

  /// Throws Error naming the setting if any is out of its bounds, if no harmonic of the trial lies in the noise's band,
  /// or if the number of samples has a prime factor above largest_fft_prime (sim/fft.hpp); all other members assume a
  /// valid protocol.
  void validate() const;
  /// Throws Error naming the setting for what can be simulated but is no experiment: control characters in the name, a
  /// body that has less inertia about the ankles than its mass at its centre (parallel axis theorem; 1e-6 of it are
  /// rounding), a measured tilt whose cycles do not join. For protocols that people write: data sets and models may
  /// carry older ones that it would refuse.
  void refuse_implausible() const;
  /// The stimulus if it is a sequence; throws Error if it is of another kind.
  Sequence& sequence();
  const Sequence& sequence() const;

  // What all kinds of stimulus have. A sequence's lengths are counted anew at each call: keep them out of inner
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
};

/// Two protocols play the same stimulus to the same body and sample it alike; noise may differ.
bool same_experiment(const Protocol& a, const Protocol& b);

/// 121 s: 242 states of 0.25 s, twice.
Protocol default_protocol();
/// The Freiburg short protocol, 63.7 s: 80 states of 0.25 s, three times, between 1.97 s and 1.73 s of rest.
Protocol short_protocol();

/// The tilt of a valid protocol. A ternary sequence's is a whole number of states times one factor, so that it does not
/// drift; its grid is the widest with a point at every change of the velocity. The grid of all other kinds is that of
/// the samples.
Stimulus make_stimulus(const Protocol& protocol);

}  // namespace decid::sim
