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

/// The estimate that a model's network makes from one trial.
struct Estimate {
  /// SI units. Trials like the model's training give parameters in their ranges or a little outside. Other trials can
  /// give any value, also below 0. A warning names each parameter that lies outside.
  sim::Parameters parameters;
  /// The distribution of the parameters; `parameters` are its means. Empty if the model's head gives only point
  /// estimates.
  std::optional<ParameterDistribution> distribution = {};
  std::vector<float> image;  ///< of the trial, before row scaling, channel-major; its shape is the model's
  /// Distance of the features from the features of simulated trials (network/ood_detector.hpp). NaN if the model has no
  /// OOD detector.
  double distance = std::numeric_limits<double>::quiet_NaN();
  Warnings warnings;  ///< what looks odd
};

/// Frequency responses of sway to tilt, band by band: of the recording and of the identified controller.
struct FrequencyResponses {
  int cycles = 0;  ///< stimulus cycles that were analysed
  std::vector<sim::FrfPoint> recorded;
  std::vector<sim::FrfPoint> model;  ///< of Explanation::fitted_rad; empty if the body fell
  std::vector<sim::Complex> linear;  ///< of the closed loop at theta = 0, with the start and the gain of fitted_rad
};

/// Comparison of a trial with trials simulated from the parameters identified in it.
struct Explanation {
  /// The noise-free trial as the recording has it: for a posterior from its mean start on and times its mean gain; gaps
  /// bridged. Shorter than the protocol if the body fell.
  std::vector<float> fitted_rad;
  /// Residual between the noise-free trial and the recording, means removed; NaN if the body fell.
  double rms_residual_deg = std::numeric_limits<double>::quiet_NaN();
  double variance_accounted_for = std::numeric_limits<double>::quiet_NaN();  ///< 1 - var(residual) / var(sway)
  /// Fraction of the controller's response to the tilt in the recording (response_ratio.hpp), which for a posterior has
  /// the mean gain: 1 all, 0 none; NaN unknown.
  double response_ratio = std::numeric_limits<double>::quiet_NaN();
  /// Mean and standard deviation of the response ratio over trials of the controller; NaN unknown.
  double response_ratio_mean = std::numeric_limits<double>::quiet_NaN();
  double response_ratio_sd = std::numeric_limits<double>::quiet_NaN();
  double gain = 1.0;  ///< recorded over true sway, of a posterior
  /// Out-of-distribution score of the recording (response_ratio.hpp); above 1 it is flagged. Rate of false alarms:
  /// docs/reference/accuracy.md. NaN if the model has no OOD detector.
  double ood_score = std::numeric_limits<double>::quiet_NaN();
  /// The reason why the recording is out of distribution; empty: it is not, or no model has judged it.
  std::string unlike_training;
  std::optional<FrequencyResponses> frf;  ///< empty if the stimulus has none; a warning says why
  Warnings warnings;
};

}  // namespace decid
