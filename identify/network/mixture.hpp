// A distribution over the parameters, described by a network's outputs: a mixture of Gaussians in unbounded coordinates
// x, where a parameter is low + range * Phi(x). So the prior of x is standard normal, and no parameter is outside of
// the ranges.
//
// Component k of P parameters has 1 + P + P (P + 1) / 2 outputs: the logarithm of its weight, up to a constant of all
// components; its centre; the logarithms of the diagonal of A, within +-mixture_limit; the entries of A below the
// diagonal, row by row. A is lower triangular, and A^t A the inverse of its covariance.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace decid {

/// Limit of the logarithms of the diagonal of A: the standard deviation of a coordinate is e^-7 or more.
inline constexpr double mixture_limit = 7.0;

/// Returns the number of outputs that describe a mixture of this many components.
std::size_t mixture_outputs(std::size_t components, std::size_t parameters);

/// Kinds of derivatives by the outputs: exact, or balanced for training. Exact derivatives by the centre of a
/// well-determined parameter are up to some thousand times larger than for an ill-determined one. Exact derivatives by
/// A are mostly noise, which drowns the signal of the centres in the layers before. A network then learns the means
/// badly or diverges (Seitzer et al., "On the pitfalls of heteroscedastic uncertainty estimation with probabilistic
/// neural networks", ICLR 2022; docs/research/notebook.md). `balanced` uses the natural derivative by the centre
/// (Amari, Neural Computation 10, 1998): the exact one divided by the inverse of the covariance, which is x - centre
/// times the component's fraction of the density. It uses balanced_rate times the derivatives by A. Both vanish where
/// the exact ones do.
enum class Gradients { exact, balanced };
inline constexpr double balanced_rate = 0.2;

/// Computes the logarithm of the density at x, and its derivatives by the outputs. outputs, by_output: mixture_outputs
/// values. Throws Error for other numbers.
double mixture_log_density(std::size_t components, std::span<const double> outputs, std::span<const double> x,
                           std::span<double> by_output, Gradients slopes = Gradients::exact);

/// Returns the coordinate x of a parameter at this fraction of its range. Fractions nearer to an end than 1e-4 count as
/// 1e-4 from it, because coordinates are infinite at the ends.
double mixture_coordinate(double fraction);

/// The distribution in such outputs, each parameter as a fraction of its range. Densities refer to these fractions: a
/// uniform distribution has density 1.
class Mixture {
 public:
  Mixture() = default;  ///< empty
  /// Throws Error for a number of outputs that is not mixture_outputs.
  Mixture(std::size_t components, std::size_t parameters, std::span<const double> outputs);

  std::size_t parameters() const noexcept { return parameters_; }
  std::size_t components() const noexcept { return components_.size(); }
  // Returns one component, in coordinates x; covariance: a square, row after row.
  double weight(std::size_t component) const { return components_[component].weight; }
  std::span<const double> centre(std::size_t component) const { return components_[component].centre; }
  std::span<const double> covariance(std::size_t component) const { return components_[component].covariance; }
  double mean(std::size_t parameter) const;
  double stddev(std::size_t parameter) const;
  /// Returns the quantile, as a fraction of the range, of this probability, 0 < probability < 1.
  double quantile(std::size_t parameter, double probability) const;
  /// Returns the probability that the parameter is below this fraction: 0 and 1 outside of the range.
  double below(std::size_t parameter, double fraction) const;
  double correlation(std::size_t a, std::size_t b) const;
  /// Returns the marginal log density of one parameter.
  double log_density(std::size_t parameter, double fraction) const;
  /// Returns the joint log density of all parameters. Throws Error for another number of fractions than parameters().
  double log_density(std::span<const double> fractions) const;

  template <class Archive>
  void archive(Archive& a) {
    a(parameters_, outputs_, components_);
  }

 private:
  struct Component {
    double weight;
    std::vector<double> centre, covariance;  // covariance: a square, row after row
    template <class Archive>
    void archive(Archive& a) {
      a(weight, centre, covariance);
    }
  };
  double second_moment(std::size_t a, std::size_t b) const;
  double below_coordinate(std::size_t parameter, double x) const;

  std::size_t parameters_ = 0;
  std::vector<double> outputs_;
  std::vector<Component> components_;
};

}  // namespace decid
