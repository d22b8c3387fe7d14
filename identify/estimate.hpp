// An identified trial: its parameters, and how well they explain what was recorded.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "base/warning.hpp"
#include "identify/network/distribution.hpp"
#include "recording/trial.hpp"
#include "sim/frf.hpp"
#include "sim/parameters.hpp"

namespace decid {

/// What a model's network finds in one trial.
struct Estimate {
  /// SI units. Those of a trial like the model's training lie in their ranges or a little outside; those of others may
  /// lie anywhere, below 0 too. A warning names each that is outside.
  sim::Parameters parameters;
  /// How sure the network is of them; `parameters` are its means. Empty if the model's head gives point estimates
  /// alone.
  std::optional<ParameterDistribution> distribution = {};
  std::vector<float> image;  ///< of the trial, before row scaling, channel-major; its shape is the model's
  /// How far the features are from those of simulated trials (familiarity.hpp). NaN if the model has no familiarity.
  double distance = std::numeric_limits<double>::quiet_NaN();
  Warnings warnings;  ///< what looks odd
};

/// Frequency response of sway to tilt: the recording's, and that of the identified controller, band by band.
struct FrequencyResponses {
  int cycles = 0;  ///< of the stimulus, that were analysed
  std::vector<sim::FrfPoint> recorded;
  std::vector<sim::FrfPoint> model;  ///< of the noise-free trial; empty if that fell over
  std::vector<sim::Complex> linear;  ///< of the closed loop at theta = 0
};

/// What trials simulated from a set of parameters show about the trial that they were identified from.
struct Explanation {
  std::vector<float> fitted_rad;  ///< the noise-free trial; shorter than the protocol if the body fell
  /// Of the noise-free trial beside the recording, means removed; NaN if it fell.
  double rms_residual_deg = std::numeric_limits<double>::quiet_NaN();
  double variance_accounted_for = std::numeric_limits<double>::quiet_NaN();  ///< 1 - var(residual) / var(sway)
  /// How much of the controller's response to the tilt is in the recording (following.hpp): 1 all, 0 none; NaN unknown.
  double response_ratio = std::numeric_limits<double>::quiet_NaN();
  /// Mean and standard deviation of that among trials of the controller; NaN unknown.
  double response_ratio_mean = std::numeric_limits<double>::quiet_NaN();
  double response_ratio_sd = std::numeric_limits<double>::quiet_NaN();
  /// How little the recording is like what the model was trained on (following.hpp); 96 of 100 simulated trials are
  /// below 1. NaN if the model has no familiarity.
  double ood_score = std::numeric_limits<double>::quiet_NaN();
  /// Why the model takes the recording for unlike its training; empty: it does not, or no model has judged.
  std::string unlike_training;
  std::optional<FrequencyResponses> frf;  ///< empty if the stimulus has none; a warning says why
  Warnings warnings;
};

}  // namespace decid
