// Measures fits of realistic recordings: test trials with one recording condition or fault each. Reports the errors of
// the estimates, the coverage of their intervals, and their trust levels.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "identify/evaluation/calibration.hpp"
#include "identify/evaluation/fault_trials.hpp"
#include "identify/fit_recordings.hpp"

namespace decid {

/// How the test trials of one row are recorded.
struct FitCondition {
  Fault fault;             ///< its name and size name the row
  sim::Protocol recorded;  ///< protocol of simulation and recording
};

/// Returns no condition, each condition of the protocol on its own in all trials, and all conditions together as in the
/// protocol; all of the experiment's own body, because a fit knows the person's height.
std::vector<FitCondition> fit_conditions(const sim::Protocol& protocol);
/// Returns each of faults_of_people() that the protocol can have. Start and gain of the trials are drawn from the
/// priors, unless the fault is a start or gain.
std::vector<FitCondition> fit_faults(const sim::Protocol& protocol, const posterior::Priors& priors);

/// One row of the table.
struct FitConditionFigures {
  Fault fault;
  /// Calibration of the estimates that users get: from the posterior, or from the network if the chains disagree; empty
  /// where no parameters are true.
  std::optional<Calibration> figures;
  std::optional<Calibration> usable_figures;  ///< over the usable trials; empty without one
  int trials = 0;
  int usable = 0, caution = 0, not_usable = 0;  ///< trials by their trust
  int usable_far_off = 0;  ///< usable answers with a parameter further than 5 standard deviations from the truth
  int from_network = 0;    ///< answers that come from the network
  std::map<std::string, int> codes;  ///< trials by the codes of their cautions and worse
  double mean_s = 0.0, max_s = 0.0;  ///< seconds of one core per trial
};

/// Fits the first valid trials of the seed, recorded under the condition; for leg and trunk, trials in which the body
/// stands. Throws Error if the protocol cannot be fitted, or if no trial stands. progress: may stop the row, which then
/// has no trials.
FitConditionFigures fit_condition(const Model& model, const sim::Protocol& protocol, const FitCondition& condition,
                                  const FitRequest& request, int trials, std::uint64_t seed,
                                  const FitProgress& progress = {});

}  // namespace decid
