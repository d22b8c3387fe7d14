// Simulation-based calibration: trials whose parameters are drawn from the prior, and what their posteriors say of
// them. If the posteriors are right, the truth lies anywhere among their draws with equal probability. Talts,
// Betancourt, Simpson, Vehtari, Gelman, arXiv:1804.06788.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "identify/network/model.hpp"
#include "posterior/posterior.hpp"

namespace decid {

/// One trial and its posterior, a value a parameter.
struct CalibratedTrial {
  std::uint64_t attempt = 0;  ///< of the base trials of a seed (dataset::base_trial)
  sim::Parameters truth, mean, deviation;
  std::optional<sim::Parameters> network;  ///< its answer, to stand beside
  /// Logarithm of the density at the truth over the number of parameters, see gaussian_log_score(); NaN unknown.
  double log_score = unknown_score;
  double network_log_score = unknown_score;  ///< of a network that gives distributions

  static constexpr double unknown_score = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> below;  ///< the share of the draws below the truth
  double rhat = 0.0;          ///< the largest
  double effective_draws = 0.0;
  bool agreed = false;
  double seconds = 0.0;

  template <class Archive>
  void archive(Archive& a) {
    a(attempt, truth, mean, deviation, network, log_score, network_log_score, below, rhat, effective_draws, agreed,
      seconds);
  }
};

/// The posterior of a simulated trial beside its truth. ranges: of the prior.
CalibratedTrial calibrate(const sim::Parameters& truth, const posterior::Posterior& found,
                          const sim::ParameterTable& ranges);
/// What a network says of it; nothing stands where chains have something.
CalibratedTrial calibrate(const sim::Parameters& truth, const ParameterDistribution& found);

/// Mean over the parameters of the log density at the truth, nats, of shares of the ranges: 0 where no more is known
/// than these, 0.69 where what is possible is halved. The density is that of the Gaussian, in the coordinates of
/// mixture.hpp, that has the draws' mean and covariance: of N independent draws of P parameters it is (P + 3) / (4 N)
/// too low on average. NaN if the draws do not tell a covariance.
double gaussian_log_score(const sim::Parameters& truth, std::span<const posterior::State> draws,
                          const sim::ParameterTable& ranges);

/// Over trials, for one parameter.
struct ParameterCalibration {
  double mse = 0.0;                           ///< of the mean, over `deviation` squared
  double predicted_variance = 0.0;            ///< mean variance of the draws, over the same
  double network_mse = 0.0;                   ///< NaN unless all trials have a network's answer
  double coverage50 = 0.0, coverage90 = 0.0;  ///< share of the truths in the central intervals
  /// The largest distance of the shares `below` from uniform (Kolmogorov and Smirnov). Beyond 1.36 / sqrt(trials),
  /// which is also the half width of a band about the distribution, with probability 0.05 if the posteriors are right.
  double distance = 0.0;
};

struct Calibration {
  int trials = 0, agreed = 0;
  std::vector<ParameterCalibration> parameters;
  ParameterCalibration all;                         ///< means over the parameters; the largest distance
  double log_score = 0.0, network_log_score = 0.0;  ///< means over the trials; NaN unless all have one
  double band = 0.0;                                ///< 1.36 / sqrt(trials)
};

/// deviation: what errors are divided by, that of the trials' prior. Throws Error without any trial.
Calibration calibration_of(std::span<const CalibratedTrial> trials, const sim::Parameters& deviation);
/// Of those whose chains agree alone.
Calibration calibration_of_agreeing(std::span<const CalibratedTrial> trials, const sim::Parameters& deviation);

/// What the distributions that a network gives are worth, over trials.
struct NetworkCalibration {
  Calibration figures;  ///< of its distributions; nothing stands in network_mse
  /// Mean logarithm of the density at the truth, of shares of the range, nats: 0 for a network that knows only the
  /// ranges, 0.69 more halves what is left. Of each parameter whatever the others are; not recalibrated.
  std::vector<double> log_score_per_parameter;
};
/// Trials by their outputs (see predict()) and parameters. Empty if the model's head gives point estimates alone.
/// Throws Error without any trial.
std::optional<NetworkCalibration> network_calibration(const Model& model, std::span<const float> outputs,
                                                      std::span<const sim::Parameters> truth);

/// Trials whose key lies between two values.
struct CalibrationPart {
  double low = 0.0, high = 0.0;
  Calibration figures;
};
/// The trials in three parts of equal size by a key. Throws Error for fewer than three trials.
std::vector<CalibrationPart> calibration_by(std::span<const CalibratedTrial> trials, const sim::Parameters& deviation,
                                            const std::function<double(const sim::Parameters& truth)>& key);

/// Of the body and its controller without noise and dead band, the delay taken for a lag: (2 (Kd - Kp delay) + Kd_pass)
/// / (2 sqrt(J (2 Kp + Kp_pass - m g h))); the controller answers sway twice, by servo and by its compensation of
/// gravity. Low: the sway rings, and many parameters explain it nearly as well. NaN for a body that no stiffness holds
/// up.
double damping_ratio(const sim::Parameters& parameters, const sim::Body& body);

}  // namespace decid
