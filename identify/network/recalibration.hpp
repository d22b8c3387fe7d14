// Recalibration of a network's distributions. A network that overfits its training trials gives intervals that are too
// narrow. Trials outside of the training show by how much, parameter by parameter, and the recalibration corrects the
// distributions. Method: Kuleshov, Fenner, Ermon, "Accurate uncertainties for deep learning using calibrated
// regression", ICML 2018, with a piecewise linear map.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "base/communicator.hpp"
#include "dataset/source.hpp"

namespace decid {

struct Model;

/// The corrections from such trials, one value per parameter. Empty: distributions stay as they are.
struct Recalibration {
  static constexpr std::size_t probabilities = 19;  ///< 0.05, 0.10, ... 0.95
  /// The probability level of the network's distribution below which this fraction of the truths lay.
  using Levels = std::array<double, probabilities>;

  std::vector<Levels> levels;         ///< between 0 and 1, not falling
  std::vector<double> stddev_factor;  ///< root of the sum of (truth - mean)^2 over that of deviation^2

  bool known() const noexcept { return !levels.empty(); }
  /// Returns the level at which to evaluate the network's distribution for a probability, 0 <= probability <= 1:
  /// piecewise linear from (0, 0) through the levels to (1, 1). Returns the probability itself if the recalibration is
  /// empty.
  double level(std::size_t parameter, double probability) const;
  /// Returns the inverse of level(), 0 <= level <= 1.
  double probability(std::size_t parameter, double level) const;
  /// Returns the factor of the standard deviation; 1 if the recalibration is empty.
  double factor(std::size_t parameter) const { return known() ? stddev_factor[parameter] : 1.0; }

  bool operator==(const Recalibration&) const = default;
};

/// A network's distribution at a parameter of known truth.
struct PredictedParameter {
  double below;          ///< the network's probability that the parameter is below the truth
  double error, stddev;  ///< truth - mean, and the predicted standard deviation, both in the same unit
};
/// Computes the recalibration from trials of known parameters: predicted[trial * parameters + parameter]. Throws Error
/// unless `predicted` holds whole trials, at least one, and for errors or standard deviations of a parameter that are
/// all 0 or not finite.
Recalibration fit_recalibration(std::size_t parameters, std::span<const PredictedParameter> predicted);

/// Learns the recalibration from 10,240 trials outside of the training, or all that there are: the next epoch of a
/// stream, or the validation half of a data set. The coverages of 50% and 90% intervals then have standard errors of
/// 0.5% and 0.3% (for 1,000 trials: 1.6% and 1%). Empty if the head gives no distribution, or there are fewer than
/// 1,000 trials.
Recalibration learn_recalibration(const Model& model, const dataset::TrialSource& source, int next_epoch,
                                  Communicator* ranks = nullptr);

/// Returns one line: {"levels": [...], "deviation_factor": [...]}.
std::string to_json(const Recalibration& recalibration);
/// Reads a recalibration. Throws Error for a text that is not of this form, for another number of parameters, for
/// levels that fall or are not between 0 and 1, and for factors that are not above 0. `where` names the source.
Recalibration recalibration_from_json(const std::string& text, std::size_t parameters, const std::string& where);

}  // namespace decid
