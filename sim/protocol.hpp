// A protocol is data: everything about an experiment but the seven parameters. What the platform plays, how the
// sway is sampled, whose body stands on it, which noise disturbs it.
// Sequence: pseudo-random ternary sequence of Peterka, J Neurophysiol 88, 2002, as the Freiburg platform plays it.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace decid::sim {

inline constexpr double pi = 3.14159265358979323846;
inline constexpr double rad_per_deg = pi / 180.0;
inline constexpr double gravity = 9.81;        ///< m/s^2
inline constexpr int steps_per_second = 1000;  ///< the fixed integration step is 1 ms

/// Shift register of a pseudo-random ternary sequence: each step computes v = (feedback . register) mod 3, shifts it
/// in at the front and plays it; 2 counts as -1.
struct Sequence {
  std::vector<int> feedback{0, 0, 1, -1, -1};  ///< one coefficient a stage
  std::vector<int> start{2, 0, 2, 0, 2};       ///< first content of the register, values 0..2
  double state_s = 0.25;                       ///< how long a state lasts; a multiple of 1 ms
  double amplitude_deg = 1.0;                  ///< peak to peak of the tilt
  double offset_s = 25.63;                     ///< where in the sequence the trial starts; the tilt there is called 0
  int cycles = 2;                              ///< how often the whole sequence is played
  double lead_in_s = 0.0;                      ///< level platform before the first cycle
  double lead_out_s = 0.0;                     ///< platform at rest after the last cycle

  friend bool operator==(const Sequence&, const Sequence&) = default;
};

/// The body above the ankle as a single inverted pendulum. Defaults: Winter's segments for 88.86 kg and 1.80 m.
struct Body {
  double mass_kg = 86.283;
  double com_height_m = 0.99119;
  double inertia_kgm2 = 101.895;  ///< about the ankle

  /// Gravitational stiffness m g h in N m/rad; 838.99 by default.
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
  Sequence sequence;
  double sample_rate_hz = 100.0;  ///< of the sway; divides 1000
  Body body;
  VestibularNoise vestibular_noise;
  SensorNoise sensor_noise;

  /// Throws Error naming the setting if any is out of its bounds; all that follows assumes a valid protocol.
  void validate() const;
  // The lengths below generate the sequence anew at each call: keep them out of inner loops.

  /// Length of a trial in 1 ms steps.
  int steps() const;
  int steps_per_sample() const;
  /// Samples of a trial: sample k at t = k / sample_rate_hz, k = 0 .. samples() - 1.
  int samples() const;
  double duration_s() const;
  /// Length of one cycle of the sequence in s.
  double cycle_s() const;
};

/// Two protocols play the same stimulus to the same body and sample it alike; noise may differ.
bool same_experiment(const Protocol& a, const Protocol& b);

/// 121 s: 242 states of 0.25 s, twice.
Protocol default_protocol();
/// The Freiburg short protocol, 63.7 s: 80 states of 0.25 s, three times, between 1.97 s and 1.73 s of rest.
Protocol short_protocol();

/// The whole sequence, values -1, 0, 1; 3^stages - 1 states if the feedback is primitive. Throws Error if the
/// register never returns to its start.
std::vector<int> ternary_sequence(const Sequence& sequence);

/// The stimulus of a trial: a platform tilt that is linear between the points of a uniform grid. The grid's interval is
/// a whole number of steps and divides the sample period.
struct Stimulus {
  int interval_steps = 1;          ///< 1 ms steps between two points
  std::vector<double> tilt_rad;    ///< platform in space at point k, t = k * interval, k = 0 .. intervals
  std::vector<double> rate_rad_s;  ///< its velocity between points k and k + 1, k = 0 .. intervals - 1

  /// The tilt at t = step ms, 0 <= step <= steps.
  double tilt_at(int step) const;
  /// The velocity in [step, step + 1) ms, 0 <= step < steps.
  double rate_at(int step) const { return rate_rad_s[static_cast<std::size_t>(step / interval_steps)]; }
};
/// The tilt of a ternary sequence is a whole number of states times one factor, so that it does not drift.
Stimulus make_stimulus(const Protocol& protocol);

}  // namespace decid::sim
