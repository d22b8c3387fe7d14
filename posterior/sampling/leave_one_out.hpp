// The predictive accuracy of a posterior for unseen data: leave-one-out cross-validation by importance sampling with
// smoothed largest weights (PSIS). Vehtari, Gelman, Gabry, Statistics and Computing 27, 2017; tail of the weights:
// Zhang, Stephens, Technometrics 51, 2009.
#pragma once

#include <span>
#include <vector>

namespace decid::posterior {

struct LeaveOneOut {
  double log_density = 0.0;     ///< sum over the observations of log p(observation | all others), nats
  double standard_error = 0.0;  ///< of that sum, from the differences between observations
  /// The increase of the sum if each observation is known: the number of independent parameters that the data
  /// determine.
  double effective_parameters = 0.0;
  /// The largest shape (k) of the weights' tails. Infinite where so few draws have all the weight that no tail fits.
  double max_shape = 0.0;
  int unreliable = 0;  ///< observations whose shape is above min(1 - 1 / log10(draws), 0.7): few draws dominate them
  std::vector<double> pointwise{};  ///< log p(observation | all others) of each observation, nats
  std::vector<double> shapes{};     ///< of each observation's weights
  double max_reliable_shape = 0.7;
};

/// Computes the cross-validation. log_likelihood: one draw after the other, each with log p(observation | draw) of all
/// `observations`. Throws Error for fewer than 2 observations or 25 draws, for a number of values that is not a
/// multiple of `observations`, and for values that are not finite.
LeaveOneOut leave_one_out(std::span<const double> log_likelihood, int observations);

}  // namespace decid::posterior
