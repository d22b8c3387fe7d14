// Normal posteriors within ranges: what an estimate leaves of parameters that trade off against each other and cannot
// leave their ranges. A parameter without information keeps the prior's variance. Not installed.
#pragma once

#include <span>
#include <vector>

#include "base/math/random.hpp"

namespace decid::posterior {

/// Normal prior of a fraction, within [0, 1]; precision 0: uniform.
struct FractionPrior {
  double mean = 0.5, precision = 0.0;
};

/// Returns the variances under the priors, within [0, 1].
std::vector<double> prior_variances(std::span<const FractionPrior> priors);
/// Draws an estimate of `truth`, and returns the posterior variances of the fractions given this estimate, by Gibbs
/// sampling (A. Gelfand, A. Smith, J. Am. Stat. Assoc. 85 (1990) 398-409) along the axes and along directions that
/// follow ridges: 1,000 sweeps, whose variances err by some percent, without a bias from correlations. The truth is a
/// draw of that posterior, so chains begin there. information: of the estimate, a positive definite lower triangle.
std::vector<double> variances_in_range(std::span<const double> truth, std::span<const double> information,
                                       std::span<const FractionPrior> priors, const Random& random);

}  // namespace decid::posterior
