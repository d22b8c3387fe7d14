// Measures fits of recordings as laboratories make them: test trials with one recording condition or fault each, how
// far off the answers are, whether their intervals cover the truth, and what trust they are given.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "identify/fit_recordings.hpp"
#include "identify/studies/calibration.hpp"
#include "identify/studies/fault_trials.hpp"

namespace decid {

/// How the test trials of one row are recorded.
struct FitCondition {
  Fault fault;             ///< its name and size name the row
  sim::Protocol recorded;  ///< as trials are simulated and recorded
};

/// No condition, each condition of the protocol alone in all trials, and all together as the protocol has them.
std::vector<FitCondition> fit_conditions(const sim::Protocol& protocol);
/// Each of faults_of_people() that the protocol can have, on trials whose start and gain are drawn as the priors have
/// them, unless the fault is one of these.
std::vector<FitCondition> fit_faults(const sim::Protocol& protocol, const posterior::Priors& priors);

/// One row of the table.
struct FitConditionFigures {
  Fault fault;
  /// The answers that users get: the posterior's, or the network's where the chains disagree; empty where no parameters
  /// are true.
  std::optional<Calibration> figures;
  int trials = 0;
  int usable = 0, caution = 0, not_usable = 0;  ///< trials by their trust
  int usable_far_off = 0;  ///< usable answers with a parameter further than 5 standard deviations from the truth
  int from_network = 0;    ///< answers that are the network's
  std::map<std::string, int> codes;  ///< trials by the codes of their cautions and worse
  double mean_s = 0.0, max_s = 0.0;  ///< of one core, a trial
};

/// Fits the first valid trials of the seed, recorded so. Of leg and trunk those that stand. Throws Error if the
/// protocol cannot be fitted, and where no trial stands. progress: may stop the row, which then has
/// no trials.
FitConditionFigures fit_condition(const Model& model, const sim::Protocol& protocol, const FitCondition& condition,
                                  const FitRequest& request, int trials, std::uint64_t seed,
                                  const FitProgress& progress = {});

}  // namespace decid
