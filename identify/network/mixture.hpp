// A distribution over the parameters as a network's outputs describe it: a mixture of Gaussians in coordinates x that
// are unbounded, where a parameter is low + range * Phi(x). So beforehand x is standard normal, and nothing is outside
// of the ranges.
//
// Component k of P parameters has 1 + P + P (P + 1) / 2 outputs: the logarithm of its weight, up to what all have; its
// centre; the logarithms of the diagonal of A, within +-mixture_limit; what A has below the diagonal, row by row. A is
// lower triangular, and A^t A the inverse of its covariance.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace decid {

/// Logarithms of the diagonal of A are cut off there: a coordinate is known to e^-7 at best.
inline constexpr double mixture_limit = 7.0;

std::size_t mixture_outputs(std::size_t components, std::size_t parameters);

/// Derivatives by the outputs as they are, or as a network is to follow them. As they are, those by the centre of what
/// is known well are up to some thousand times those of what is not, and those by A are mostly chance, which drowns
/// what the centres tell the layers before: a network learns the means badly or diverges (Seitzer et al., "On the
/// pitfalls of heteroscedastic uncertainty estimation with probabilistic neural networks", ICLR 2022;
/// docs/research/notebook.md). `balanced`: the natural derivative by the centre, that divided by the inverse of the
/// covariance (Amari, Neural Computation 10, 1998), which is x - centre times the component's share in the density; and
/// balanced_rate times those by A. Both vanish where the others do.
enum class Slopes { exact, balanced };
inline constexpr double balanced_rate = 0.2;

/// The logarithm of the density at x, and its derivatives by the outputs. outputs, by_output: mixture_outputs values.
/// Throws Error for other numbers.
double mixture_log_density(std::size_t components, std::span<const double> outputs, std::span<const double> x,
                           std::span<double> by_output, Slopes slopes = Slopes::exact);

/// Where a parameter at this share of its range lies. What is nearer to an end than 1e-4 counts as there, as
/// coordinates are infinite at the ends.
double mixture_coordinate(double share);

/// What such outputs say of each parameter, as a share of its range. Densities are of these shares: a parameter that is
/// known only to lie in its range has 1.
class Mixture {
 public:
  Mixture() = default;  ///< of nothing
  /// Throws Error for a number of outputs that is not mixture_outputs.
  Mixture(std::size_t components, std::size_t parameters, std::span<const double> outputs);

  std::size_t parameters() const noexcept { return parameters_; }
  double mean(std::size_t parameter) const;
  double deviation(std::size_t parameter) const;
  /// The share of the range that the parameter is below with this probability, 0 < probability < 1.
  double quantile(std::size_t parameter, double probability) const;
  /// The probability that it is below this share: 0 and 1 outside of the range.
  double below(std::size_t parameter, double share) const;
  double correlation(std::size_t a, std::size_t b) const;
  /// Of one parameter, whatever the others are.
  double log_density(std::size_t parameter, double share) const;
  /// Of all together. Throws Error for another number of shares than parameters().
  double log_density(std::span<const double> shares) const;

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
