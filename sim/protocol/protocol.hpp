// A protocol is data: an experiment, the noise that disturbs it, and its recording. It defines a trial except for the
// parameters of the controller.
#pragma once

#include <string>

#include "sim/protocol/conditions.hpp"
#include "sim/protocol/experiment.hpp"

namespace decid::sim {

/// Gaussian noise of the vestibular channel: one-sided PSD(f) = (Nv * scale)^2 / f^exponent between low and high, zero
/// outside. It repeats after its period; a trial contains the beginning of a period.
struct VestibularNoise {
  double scale_deg = 0.2;
  double low_hz = 1.0 / 121.0;
  double high_hz = 1.0;
  double exponent = 1.0;
  /// At least the trial's length; 0: twice the trial's length. A real body's noise does not repeat. A period T shows in
  /// a trial by the correlation of its two ends: the autocovariance at T minus a lag. With twice the trial's length
  /// every lag has less than 0.5% of the velocity's variance from it, for 121 s and 1 Hz; with the trial's length the
  /// last lag has all.
  double period_s = 0.0;
};

/// White measurement noise of the sway sensor, standard deviation in degrees, drawn log-uniform from [low, high] for
/// each trial; 0 and 0: none.
struct SensorNoise {
  double low_deg = 0.0;
  double high_deg = 0.0;
};

struct Noise {
  VestibularNoise vestibular;
  SensorNoise sensor;
};

/// Each trial of a stream has its own body, whose height is a factor times the experiment's (Body::of_height), drawn
/// uniformly. The experiment's own body is included: low is at most 1, high at least 1.
struct Heights {
  double low = 1.0, high = 1.0;

  bool vary() const { return low != 1.0 || high != 1.0; }
};

struct Protocol {
  std::string name = "default";
  Experiment experiment;
  Noise noise;
  Conditions conditions;
  Heights heights;
  /// The body has stood this long before the trial's first sample, swaying with its vestibular noise, on a resting
  /// platform; a whole number of sample periods, at most 60 s. 0: the trial begins at rest, upright.
  double standing_s = 0.0;
  /// True: the platform played one more cycle before the trial's first sample, behind the standing, as before a
  /// recording that was cut from a longer one. Not with a lead-in.
  bool moved_before = false;
  /// Half-width of a dead band on the body's angle before the gravity gain, for simulations only: fits and transfer
  /// functions ignore it, because what lies behind it is not linear. 0: none.
  double gravity_dead_band_deg = 0.0;
  bool names_controller = false;  ///< true: the file or the call names the controller, so a fit must include it

  /// Throws Error as Experiment::validate does, for noise out of its bounds or without a harmonic of the trial in its
  /// band, and for conditions, heights and standing out of theirs. All other functions assume a valid protocol.
  void validate() const;
  /// Throws Error for settings that can be simulated but are not an experiment: control characters in the name, and
  /// whatever Experiment::refuse_implausible refuses. Call it for protocols that users write; older data sets and
  /// models may contain such protocols.
  void refuse_implausible() const;
  /// Returns the same protocol with one body and an ideal recording: no measurement noise, no artefacts. The standing
  /// is kept.
  Protocol ideal() const;
  /// Returns the same protocol with nothing before its trial, which begins at rest, upright.
  Protocol from_rest() const;
  /// Returns the protocol that is simulated for this one: the time before its trial is a part of it. The standing is in
  /// its lead-in, and it has one more cycle if the platform moved before. Its vestibular noise has this protocol's
  /// period if that is long enough, else twice its own length.
  Protocol with_time_before() const;
  /// Returns the stimulus if it is a sequence; throws Error for other kinds.
  Sequence& sequence();
  const Sequence& sequence() const;

  const ParameterTable& parameters() const { return experiment.parameters(); }
  const Family& family() const { return experiment.family(); }
  /// Returns the parameter table with ranges for this body. Ranges of parameters that scale with m g h are the same
  /// relative to its m g h as the table's relative to the default body's.
  ParameterTable ranges() const;
  int samples() const { return experiment.samples(); }
  double duration_s() const { return experiment.duration_s(); }
  /// Returns the vestibular noise's period in samples, with the default for 0.
  int noise_period_samples() const;
  double noise_period_s() const;
};

/// Returns the default protocol, 121 s: 242 states of 0.25 s, twice.
Protocol default_protocol();
/// Returns the Freiburg short protocol, 63.7 s: 80 states of 0.25 s, three times, between 1.97 s and 1.73 s of rest. It
/// begins with the sequence's first state. The published COMTEST stimulus begins 9.12 s later in the sequence:
/// examples/comtest.json.
Protocol short_protocol();

}  // namespace decid::sim
