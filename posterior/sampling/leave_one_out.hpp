// How well a posterior predicts what it has not seen: leave-one-out cross-validation by importance sampling, the
// largest weights smoothed (PSIS). Vehtari, Gelman, Gabry, Statistics and Computing 27, 2017; tail of the weights:
// Zhang, Stephens, Technometrics 51, 2009.
#pragma once

#include <span>

namespace decid::posterior {

struct LeaveOneOut {
  double log_density = 0.0;     ///< sum over the observations of log p(observation | all others), nats
  double standard_error = 0.0;  ///< of that sum, from how the observations differ
  /// By how much the sum is larger with each observation known: as many as independent parameters that the data fix.
  double effective_parameters = 0.0;
  double max_shape = 0.0;  ///< of the weights' tails (k)
  int unreliable = 0;      ///< observations whose shape is above min(1 - 1 / log10(draws), 0.7): few draws carry them
};

/// log_likelihood: a draw after the other, each with log p(observation | draw) of all `observations`. Throws Error for
/// fewer than 2 observations or 25 draws, a number of values that is no multiple of `observations`, and values that are
/// not finite.
LeaveOneOut leave_one_out(std::span<const double> log_likelihood, int observations);

}  // namespace decid::posterior
