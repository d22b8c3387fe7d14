// A protocol is data: an experiment, the noise that disturbs it, and how it is recorded; everything about a trial but
// the parameters of the controller.
#pragma once

#include <string>

#include "sim/protocol/conditions.hpp"
#include "sim/protocol/experiment.hpp"

namespace decid::sim {

/// Gaussian noise of the vestibular channel: one-sided PSD(f) = (Nv * scale)^2 / f^exponent between low and high,
/// zero outside. It repeats after its period, of which a trial shows the beginning.
struct VestibularNoise {
  double scale_deg = 0.2;
  double low_hz = 1.0 / 121.0;
  double high_hz = 1.0;
  double exponent = 1.0;
  /// The trial's length or more; 0: twice the trial's length. No body's noise repeats. A trial shows a period T by what
  /// its two ends share: the autocovariance at T minus a lag. With twice the trial's length no lag has more than 0.5%
  /// of the velocity's variance of it, for 121 s and 1 Hz; with the trial's length the last has all.
  double period_s = 0.0;
};

/// White noise of the sway sensor, standard deviation in degrees, drawn log-uniform from [low, high] for each trial;
/// 0 and 0: none.
struct SensorNoise {
  double low_deg = 0.0;
  double high_deg = 0.0;
};

struct Noise {
  VestibularNoise vestibular;
  SensorNoise sensor;
};

/// Each trial of a stream has a body of its own, so many times as tall as the experiment's (Body::of_height), drawn
/// uniformly. The experiment's own is among them: low is 1 at most, high 1 at least.
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
  /// The body has stood, and swayed with its vestibular noise, so long before the trial's first sample, the platform at
  /// rest; a whole number of sample periods, 60 s at most. 0: the trial begins at rest, upright.
  double standing_s = 0.0;

  /// Throws Error as Experiment::validate does, for noise out of its bounds or without a harmonic of the trial in its
  /// band, and for conditions, heights and standing out of theirs; all that follows assumes a valid protocol.
  void validate() const;
  /// Throws Error for what can be simulated but is no experiment: control characters in the name, and what
  /// Experiment::refuse_implausible refuses. To be asked of what people write: data sets and models may carry such
  /// protocols from before.
  void refuse_implausible() const;
  /// The same with one body, recorded as it is: no sensor noise, no conditions. It has stood as long.
  Protocol ideal() const;
  /// The protocol that is simulated for this one: the standing is part of its lead-in. Its vestibular noise has the
  /// period of this one's if that is long enough for it, else twice its own length.
  Protocol with_standing() const;
  /// The stimulus if it is a sequence; throws Error if it is of another kind.
  Sequence& sequence();
  const Sequence& sequence() const;

  const ParameterTable& parameters() const { return experiment.parameters(); }
  /// The same with ranges for this body: those of parameters that scale with m g h are as wide over its m g h as the
  /// table's are over that of the default body.
  ParameterTable ranges() const;
  int samples() const { return experiment.samples(); }
  double duration_s() const { return experiment.duration_s(); }
  /// The vestibular noise's period in samples, as it is given or as 0 has it.
  int noise_period_samples() const;
  double noise_period_s() const;
};

/// 121 s: 242 states of 0.25 s, twice.
Protocol default_protocol();
/// The Freiburg short protocol, 63.7 s: 80 states of 0.25 s, three times, between 1.97 s and 1.73 s of rest. It begins
/// with the sequence's first state. The published COMTEST stimulus begins 9.12 s later in it: examples/comtest.json.
Protocol short_protocol();

}  // namespace decid::sim
