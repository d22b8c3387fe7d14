// Simulation-based calibration: trials whose parameters are drawn from the prior, and their posteriors. If the
// posteriors are correct, the rank of the truth among their draws is uniform. Talts, Betancourt, Simpson, Vehtari,
// Gelman, arXiv:1804.06788.
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

/// One trial and its posterior, one value per parameter.
struct CalibratedTrial {
  std::uint64_t attempt = 0;  ///< of the base trials of a seed (dataset::base_trial)
  sim::Parameters truth, mean, stddev;
  std::optional<sim::Parameters> network;  ///< the network's estimate, for comparison
  /// Logarithm of the density at the truth over the number of parameters, see gaussian_log_score(); NaN unknown.
  double log_score = unknown_score;
  double network_log_score = unknown_score;  ///< for a network that gives distributions

  static constexpr double unknown_score = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> below;     ///< fraction of the draws below the truth
  double rhat = 0.0;             ///< the largest of a parameter, and of start, gain and noise of each recording
  double effective_draws = 0.0;  ///< the fewest of those
  bool agreed = false;
  double seconds = 0.0;

  template <class Archive>
  void archive(Archive& a) {
    a(attempt, truth, mean, stddev, network, log_score, network_log_score, below, rhat, effective_draws, agreed,
      seconds);
  }
};

/// Compares the posterior of a simulated trial, or of several trials with common parameters, whose draws are the same
/// in all (posterior::sample_joint), with the truth. R-hat, effective draws and agreement are the worst of all trials,
/// with the start, gain and noise of each. found: at least one; ranges: of the prior.
CalibratedTrial calibrate(const sim::Parameters& truth, std::span<const posterior::Posterior> found,
                          const sim::ParameterTable& ranges);
/// Compares a network's distribution with the truth; fields of chains stay empty.
CalibratedTrial calibrate(const sim::Parameters& truth, const ParameterDistribution& found);

/// Returns the mean over the parameters of the log density at the truth, nats, over fractions of the ranges: 0 for the
/// prior, 0.69 if the plausible range is halved. The density is a Gaussian with the draws' mean and covariance, in the
/// coordinates of mixture.hpp. For N independent draws of P parameters it is (P + 3) / (4 N) too low on average. NaN if
/// the draws do not determine a covariance. Fixed parameters do not count.
double gaussian_log_score(const sim::Parameters& truth, std::span<const posterior::State> draws,
                          const sim::ParameterTable& ranges);

/// Calibration of one parameter over trials.
struct ParameterCalibration {
  double mse = 0.0;                           ///< of the mean, over `stddev` squared
  double predicted_variance = 0.0;            ///< mean variance of the draws, over the same
  double network_mse = 0.0;                   ///< NaN unless all trials have a network's answer
  double coverage50 = 0.0, coverage90 = 0.0;  ///< fraction of the truths in the central intervals
  /// The largest distance of the fractions `below` from uniform (Kolmogorov and Smirnov). If the posteriors are
  /// correct, it exceeds 1.36 / sqrt(trials) with probability 0.05; that is also the half width of a band about the
  /// distribution.
  double distance = 0.0;
};

struct Calibration {
  int trials = 0, agreed = 0;
  std::vector<ParameterCalibration> parameters;
  ParameterCalibration all;                         ///< means over the inferred parameters; the largest distance
  double log_score = 0.0, network_log_score = 0.0;  ///< means over the trials; NaN unless all have one
  double band = 0.0;                                ///< 1.36 / sqrt(trials), for one parameter's distance
  /// For the largest distance of the m inferred parameters, all.distance: correct posteriors exceed it with probability
  /// 0.05 at most (Bonferroni): sqrt(log(2 m / 0.05) / 2 / trials), 1.68 / sqrt(trials) of seven.
  double band_of_all = 0.0;
};

/// Computes the calibration over trials. stddev: the standard deviation of the trials' prior, which divides the
/// errors. Throws Error without any trial.
Calibration compute_calibration(std::span<const CalibratedTrial> trials, const sim::Parameters& stddev);
/// Computes the calibration over only the trials whose chains agree.
Calibration calibration_of_agreeing(std::span<const CalibratedTrial> trials, const sim::Parameters& stddev);

/// Calibration of a network's distributions over trials.
struct NetworkCalibration {
  Calibration figures;  ///< of its distributions; network_mse is not set
  /// Mean log density at the truth of each parameter's marginal, over fractions of the range, nats; not recalibrated.
  /// It is 0 for a network that gives only the ranges; 0.69 more halves the remaining range.
  std::vector<double> log_score_per_parameter;
};
/// Computes the calibration of trials from their outputs (see predict()) and parameters. Empty if the model's head
/// gives only point estimates. Throws Error without any trial.
std::optional<NetworkCalibration> network_calibration(const Model& model, std::span<const float> outputs,
                                                      std::span<const sim::Parameters> truth);

/// Trials whose key lies between two values.
struct CalibrationPart {
  double low = 0.0, high = 0.0;
  Calibration figures;
};
/// Splits the trials by a key into three parts of equal size. Throws Error for fewer than three trials.
std::vector<CalibrationPart> calibration_by(std::span<const CalibratedTrial> trials, const sim::Parameters& stddev,
                                            const std::function<double(const sim::Parameters& truth)>& key);

/// Returns the damping ratio of the body and its controller without noise and dead band, the delay approximated by a
/// lag: (r (Kd - Kp delay) + Kd_pass) / (2 sqrt(J (r Kp + Kp_pass - m g h))). r, 2 in `dec`: the sum of the gains by
/// which the controller responds to sway, its servo's and its compensation of gravity. Slow and torque feedback are
/// left out. If the ratio is low, the sway rings, and many parameters explain it nearly as well. NaN if the stiffness
/// is too low to hold the body up.
double damping_ratio(const sim::Parameters& parameters, const sim::Experiment& experiment);

}  // namespace decid
