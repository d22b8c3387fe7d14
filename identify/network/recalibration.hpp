// How far a network's distributions are believed. A network that has learnt its training trials too well promises more
// than it keeps; trials that it was not trained on show by how much, parameter by parameter, and what it says is
// corrected by that. Method: Kuleshov, Fenner, Ermon, "Accurate uncertainties for deep learning using calibrated
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

/// What such trials have shown, a value a parameter. Empty: distributions are believed as they are.
struct Recalibration {
  static constexpr std::size_t probabilities = 19;  ///< 0.05, 0.10, ... 0.95
  /// How probable it was, by the network, that the parameter is lower than what this share of the truths was below.
  using Levels = std::array<double, probabilities>;

  std::vector<Levels> levels;            ///< between 0 and 1, not falling
  std::vector<double> deviation_factor;  ///< root of the sum of (truth - mean)^2 over that of deviation^2

  bool known() const noexcept { return !levels.empty(); }
  /// What the network is to be asked for where a share is wanted, 0 <= share <= 1: piecewise linear from (0, 0) through
  /// the levels to (1, 1). The share itself if nothing is known.
  double level(std::size_t parameter, double share) const;
  /// The inverse, 0 <= level <= 1.
  double share(std::size_t parameter, double level) const;
  /// 1 if nothing is known.
  double factor(std::size_t parameter) const { return known() ? deviation_factor[parameter] : 1.0; }

  bool operator==(const Recalibration&) const = default;
};

/// What a network said of a parameter whose truth is known.
struct Said {
  double below;             ///< how probable it was that the parameter is lower than the truth
  double error, deviation;  ///< truth - mean, and the deviation that was promised, in any one unit
};
/// From trials of known parameters: said[trial * parameters + parameter]. Throws Error unless they are whole trials,
/// one at least.
Recalibration recalibration_of(std::size_t parameters, std::span<const Said> said);

/// Learned from 10,240 trials that the network was not trained on, or as many as there are: the next epoch's of a
/// stream, the validation half of a data set. What intervals of 50 and 90 % then cover has a standard error of 0.5 and
/// 0.3 % (of 1,000 trials: 1.6 and 1 %). Empty if the head gives no distribution, or there are fewer than 1,000.
Recalibration learn_recalibration(const Model& model, const dataset::TrialSource& source, int next_epoch,
                                  Communicator* ranks = nullptr);

/// One line: {"levels": [...], "deviation_factor": [...]}.
std::string to_json(const Recalibration& recalibration);
/// Throws Error for a text that is not of this form, for another number of parameters, for levels that fall or are not
/// between 0 and 1, and for factors that are not above 0. `where` names the source.
Recalibration recalibration_from_json(const std::string& text, std::size_t parameters, const std::string& where);

}  // namespace decid
