// Measures fits of recordings as laboratories make them: test trials with one recording condition each, how far off
// the answers are, whether their intervals cover the truth, and what trust they are given.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "identify/calibration.hpp"
#include "identify/fit_recordings.hpp"

namespace decid {

/// One row of the table.
struct FitConditionFigures {
  std::string name;  ///< a condition's key (sim/conditions.hpp), "none" or "all"
  /// The answers that users get: the posterior's, or the network's where the chains disagree.
  Calibration figures;
  int usable = 0, caution = 0, not_usable = 0;  ///< trials by their trust
  int from_network = 0;                         ///< answers that are the network's
  double mean_s = 0.0, max_s = 0.0;             ///< of one core, a trial
};

/// Rows: no condition, each condition of the protocol alone in all trials, and all together as the protocol has them;
/// the same valid trials of the seed in each row, with the protocol's measurement noise and standing time. announce:
/// called before each row; false stops, and the rows until then are returned. Throws Error if the protocol cannot be
/// fitted.
std::vector<FitConditionFigures> fit_conditions(const Model& model, const sim::Protocol& protocol,
                                                const FitRequest& request, int trials, std::uint64_t seed,
                                                const std::function<bool(const std::string& name)>& announce);

}  // namespace decid
