// The evidence of one recording about its person: the distribution of the parameters under the first stage's prior,
// with that prior divided out. Every parameter is a coordinate x with fraction of range = Phi(x), so the uniform prior
// of x is standard normal, and dividing it out subtracts 1 from the diagonal of a component's precision.
//
// The evidence is a mixture of Gaussians in x. A network gives one (identify/network/mixture.hpp). Draws of a sampler
// become one Gaussian each, of the draws' own covariance times h^2, with centres drawn together by sqrt(1 - h^2), so
// that the mixture has the draws' mean and covariance (M. West, J. R. Stat. Soc. B 55 (1993) 409-422). h is
// Silverman's width for the number of draws: about 0.5 for 256 draws of seven parameters, and 0 in the limit.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "identify/network/distribution.hpp"

namespace decid::cohort {

class Measurement {
 public:
  /// The maximum number of components that draws become; more draws are thinned evenly.
  static constexpr std::size_t max_components = 256;

  /// Makes the evidence from draws: fractions of the ranges, draw by draw, all parameters each. log_weights: one per
  /// draw, for draws under another prior than the uniform one: the logarithm of uniform over actual prior density;
  /// empty: none. Throws Error for fewer than 16 draws, for another number of values, and for values that are not
  /// finite.
  static Measurement of_draws(std::size_t parameters, std::span<const double> fractions,
                              std::span<const double> log_weights = {});
  /// Makes the evidence from a network's recalibrated distribution.
  static Measurement of_distribution(const ParameterDistribution& distribution);

  std::size_t parameters() const noexcept { return parameters_; }
  std::size_t components() const noexcept { return log_weights_.size(); }

  /// Returns the variance of one coordinate's evidence, without the prior's part; at most 99.
  double variance(std::size_t parameter) const { return variances_[parameter]; }

  // For the sampler. Symmetric matrices are lower triangles, row after row (base/math/cholesky.hpp).
  std::size_t shapes() const noexcept { return precisions_.size(); }
  /// Returns the precision of the components of one shape, before the prior's 1 is subtracted.
  std::span<const double> precision(std::size_t shape) const { return precisions_[shape]; }
  std::size_t shape_of(std::size_t component) const { return shapes_ == Shapes::common ? 0 : component; }
  /// Returns the logarithm of weight times root of the precision's determinant.
  double log_weight(std::size_t component) const { return log_weights_[component]; }
  double centre(std::size_t component, std::size_t parameter) const {
    return centres_[parameter * components() + component];
  }
  /// Returns one parameter of all centres.
  std::span<const double> centres(std::size_t parameter) const {
    return std::span(centres_).subspan(parameter * components(), components());
  }

 private:
  enum class Shapes { common, own };
  void set_variances(std::span<const double> posterior_variances);

  std::size_t parameters_ = 0;
  Shapes shapes_ = Shapes::common;  ///< one for all components, or one each
  std::vector<double> log_weights_, centres_, variances_;
  std::vector<std::vector<double>> precisions_;
};

}  // namespace decid::cohort
