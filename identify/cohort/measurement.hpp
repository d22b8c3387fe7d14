// The evidence of one recording about its person: the distribution of the parameters under the first stage's prior,
// with that prior divided out. Every parameter is a coordinate x with fraction of range = Phi(x), so the uniform prior
// of x is standard normal, and dividing it out subtracts 1 from the diagonal of a component's precision.
//
// The evidence is a mixture of Gaussians in x. A network gives one (identify/network/mixture.hpp); one to four are
// fitted to the draws of a sampler (draws_mixture.hpp), and have the draws' mean. The precision of a component of n
// effective draws is that of their covariance times (n - d - 2) / n for d parameters: the inverse of a covariance of
// few draws is too large by this on average (K. Mardia, J. Kent, J. Bibby, Multivariate Analysis, 1979, 3.4).
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "identify/cohort/draws_mixture.hpp"
#include "identify/network/distribution.hpp"

namespace decid::cohort {

class Measurement {
 public:
  Measurement() = default;  ///< empty
  /// The maximum number of draws that are used; more are thinned evenly.
  static constexpr std::size_t max_draws = 1024;

  /// Makes the evidence from draws: fractions of the ranges, draw by draw, all parameters each. log_weights: one per
  /// draw, for draws under another prior than the uniform one: the logarithm of uniform over actual prior density;
  /// empty: none. effective_draws: the number of independent draws that tell as much, without the weights, which take
  /// their part of it; empty: they are independent.
  /// Throws Error for fewer than 16 draws, for another number of values, for values that are not finite, and for
  /// weights that leave fewer than min_weighted_draws effective draws, and fewer than half of those used: these cannot
  /// represent the wider density.
  static Measurement of_draws(std::size_t parameters, std::span<const double> fractions,
                              std::span<const double> log_weights = {}, std::optional<double> effective_draws = {});
  static constexpr double min_weighted_draws = 64.0;
  /// Makes the evidence from a network's recalibrated distribution.
  static Measurement of_distribution(const ParameterDistribution& distribution);

  std::size_t parameters() const noexcept { return parameters_; }
  std::size_t components() const noexcept { return log_weights_.size(); }

  /// Returns the variance of one coordinate's evidence, without the prior's part; at most 99.
  double variance(std::size_t parameter) const { return variances_[parameter]; }

  // For the sampler.
  /// Returns a component's precision, before the prior's 1 is subtracted: a lower triangle (base/math/cholesky.hpp).
  std::span<const double> precision(std::size_t component) const { return precisions_[component]; }
  /// Returns the logarithm of weight times root of the precision's determinant.
  double log_weight(std::size_t component) const { return log_weights_[component]; }
  double centre(std::size_t component, std::size_t parameter) const { return centres_[component][parameter]; }

 private:
  explicit Measurement(Gaussians gaussians);

  std::size_t parameters_ = 0;
  std::vector<double> log_weights_, variances_;
  std::vector<std::vector<double>> centres_, precisions_;
};

}  // namespace decid::cohort
