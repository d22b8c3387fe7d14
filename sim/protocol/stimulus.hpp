// The platform's motion: kinds of stimulus as data, and the tilt made from them. Every kind describes one cycle, which
// is played `cycles` times between a lead-in and a lead-out at rest; the tilt at the start of the trial is 0. A new
// kind is a struct here, in StimulusKind, with functions in sim/protocol/stimulus.cpp and keys in
// sim/protocol/detail/stimulus_json.cpp.
#pragma once

#include <cstddef>
#include <string>
#include <variant>
#include <vector>

namespace decid::sim {

/// The shift register of a pseudo-random ternary sequence (Peterka, J Neurophysiol 88, 2002, as on the Freiburg
/// platform). Each step computes v = (feedback . register) mod 3, shifts it in at the front and plays it; 2 counts as
/// -1.
struct Sequence {
  std::vector<int> feedback{0, 0, 1, -1, -1};  ///< one coefficient per stage
  std::vector<int> start{2, 0, 2, 0, 2};       ///< initial content of the register, values 0..2
  double state_s = 0.25;                       ///< duration of a state; a multiple of 1 ms
  double amplitude_deg = 1.0;                  ///< peak to peak of the tilt
  double offset_s = 25.63;                     ///< the trial's start in the sequence; the tilt there is 0
  int cycles = 2;                              ///< repetitions of the whole sequence
  double lead_in_s = 0.0;                      ///< level platform before the first cycle
  double lead_out_s = 0.0;                     ///< platform at rest after the last cycle

  friend bool operator==(const Sequence&, const Sequence&) = default;
};

// The kinds below are given at the samples of the sway and are linear between them; lead-in, cycle and lead-out are
// whole sample periods.

/// A recorded tilt: sample k at k / sample_rate. Its first value counts as 0. With several cycles the first sample
/// follows the last; at the end of the trial the last sample is held.
struct MeasuredTilt {
  std::vector<double> tilt_deg;  ///< 2 to 1,000,000 samples at the protocol's sample rate
  int cycles = 1;
  double lead_in_s = 0.0;
  double lead_out_s = 0.0;

  friend bool operator==(const MeasuredTilt&, const MeasuredTilt&) = default;
};

struct Sine {
  double frequency_hz = 0.0;   ///< up to a tenth of the sample rate, where linear interpolation lowers its peak by 3%
  double amplitude_deg = 0.0;  ///< half of its peak-to-peak tilt
  double phase_deg = 0.0;      ///< 0 starts with the highest velocity, 90 at the peak

  friend bool operator==(const Sine&, const Sine&) = default;
};

/// A sum of sines, sum of A (sin(2 pi f t + phase) - sin(phase)), t from the start of the cycle.
struct Sines {
  std::vector<Sine> components;  ///< 1 to 100
  double cycle_s = 0.0;          ///< with several cycles it must be a whole number of every component's periods
  int cycles = 1;
  double lead_in_s = 0.0;
  double lead_out_s = 0.0;

  friend bool operator==(const Sines&, const Sines&) = default;
};

/// One movement of the platform, at rest before and after it.
struct Move {
  enum class Shape {
    pulse,  ///< out and back: A/2 (1 - cos(2 pi t / duration))
    step,   ///< to a new tilt: A/2 (1 - cos(pi t / duration))
  };
  Shape shape = Shape::pulse;
  double start_s = 0.0;        ///< from the start of the cycle; a multiple of 1 ms
  double duration_s = 0.0;     ///< at least 10 sample periods, a multiple of 1 ms
  double amplitude_deg = 0.0;  ///< maximum tilt; may be negative

  friend bool operator==(const Move&, const Move&) = default;
};

/// Raised cosines, one after the other.
struct RaisedCosines {
  std::vector<Move> moves;  ///< 1 to 10,000, in time order, without overlap, ending within the cycle
  double cycle_s = 0.0;     ///< with several cycles the steps must add up to 0
  int cycles = 1;
  double lead_in_s = 0.0;
  double lead_out_s = 0.0;

  friend bool operator==(const RaisedCosines&, const RaisedCosines&) = default;
};

using StimulusKind = std::variant<Sequence, MeasuredTilt, Sines, RaisedCosines>;

/// The tilt of a trial: linear between the points of a uniform grid. The grid's interval is a whole number of steps and
/// divides the sample period.
struct Stimulus {
  int interval_steps = 1;          ///< 1 ms steps between two points
  std::vector<double> tilt_rad;    ///< platform in space at point k, t = k * interval, k = 0 .. intervals
  std::vector<double> rate_rad_s;  ///< its velocity between points k and k + 1, k = 0 .. intervals - 1

  /// Returns the tilt at t = step ms, 0 <= step <= steps.
  double tilt_at(int step) const;
  /// Returns the velocity in [step, step + 1) ms, 0 <= step < steps.
  double rate_at(int step) const { return rate_rad_s[static_cast<std::size_t>(step / interval_steps)]; }
  /// Returns the highest minus lowest tilt.
  double peak_to_peak_rad() const;
};

/// Returns the whole sequence, values -1, 0, 1; 3^stages - 1 states if the feedback is primitive. Throws Error unless
/// feedback and start have the same number of stages, 2 to 12, and if the register never returns to its start.
std::vector<int> ternary_sequence(const Sequence& sequence);

/// Returns the reason why the first sample cannot follow the last, at a measured tilt's joint between two cycles; empty
/// if it can. The step there may be 5 times the largest one within the cycle, or 0.01 degrees. This allows for a
/// recording that was cut a few samples short, and for noise at its ends.
std::string broken_joint(const std::vector<double>& tilt_deg);

/// Returns the length of one cycle in 1 ms steps. It may exceed the bounds of a trial; it is meaningless for an invalid
/// stimulus.
long long cycle_steps(const StimulusKind& kind, int steps_per_sample);

}  // namespace decid::sim
