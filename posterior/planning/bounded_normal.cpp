// Normal posteriors within ranges: see bounded_normal.hpp.
#include "posterior/planning/bounded_normal.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/math/cholesky.hpp"
#include "base/math/math.hpp"

namespace decid::posterior {
namespace {

constexpr int sweeps = 1000, prior_grid = 400;
constexpr double min_precision = 1e-6;  // of a fraction: nothing is known
constexpr double narrow_precision = 1e4, reach_sd = 8.0;

/// Returns the quantile of a normal distribution within [low, high]. Far outside of it the nearer end is the quantile.
double quantile_within(double mean, double sd, double low, double high, double probability) {
  if (mean < low) return -quantile_within(-mean, sd, -high, -low, 1.0 - probability);  // small probabilities are exact
  const double below = normal_distribution((low - mean) / sd), above = normal_distribution((high - mean) / sd);
  const double within = below + probability * (above - below);
  if (!(above > below && within > 0.0 && within < 1.0)) return std::clamp(mean, low, high);
  return std::clamp(mean + sd * inverse_normal(within), low, high);
}

/// A chain of draws from a normal distribution within the unit cube. A sweep draws along each axis, and along
/// directions in which the unbounded distribution is independent: the columns d of L^-T, if the precision is L L^t.
/// Axes alone hardly move along a ridge, directions alone hardly at the cube's corners.
class CubeChain {
 public:
  /// precision: positive on the diagonal, lower triangle; pull: precision times mean.
  CubeChain(std::vector<double> precision, std::vector<double> pull, std::span<const double> begin)
      : size_(pull.size()),
        precision_(std::move(precision)),
        pull_(std::move(pull)),
        u_(begin.begin(), begin.end()),
        inverse_(precision_),
        has_directions_(factorize(size_, inverse_)) {
    if (has_directions_) invert_lower(size_, inverse_);
  }

  const std::vector<double>& sweep(const Random& random, std::uint64_t& used) {
    for (std::size_t i = 0; i < size_; ++i) {
      double sum = pull_[i];
      for (std::size_t j = 0; j < size_; ++j) sum -= i == j ? 0.0 : at(i, j) * u_[j];
      u_[i] = quantile_within(sum / at(i, i), 1.0 / std::sqrt(at(i, i)), 0.0, 1.0, random.uniform(used++));
    }
    for (std::size_t k = 0; has_directions_ && k < size_; ++k) move_along(k, random.uniform(used++));
    return u_;
  }

 private:
  double at(std::size_t i, std::size_t j) const { return precision_[triangle(std::max(i, j)) + std::min(i, j)]; }

  /// Draws along d = column k of L^-T, row k of L^-1, where the unbounded distribution has the variance 1.
  void move_along(std::size_t k, double probability) {
    const double* const d = inverse_.data() + triangle(k);
    double mean = 0.0, low = -std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t i = 0; i <= k; ++i) {
      double gradient = pull_[i];
      for (std::size_t j = 0; j < size_; ++j) gradient -= at(i, j) * u_[j];
      mean += d[i] * gradient;
      if (d[i] == 0.0) continue;
      const double to_zero = -u_[i] / d[i], to_one = (1.0 - u_[i]) / d[i];
      low = std::max(low, std::min(to_zero, to_one));
      high = std::min(high, std::max(to_zero, to_one));
    }
    const double step = quantile_within(mean, 1.0, low, high, probability);
    for (std::size_t i = 0; i <= k; ++i) u_[i] = std::clamp(u_[i] + step * d[i], 0.0, 1.0);
  }

  std::size_t size_;
  std::vector<double> precision_, pull_, u_;
  std::vector<double> inverse_;  // of L, lower triangle
  bool has_directions_;
};

}  // namespace

std::vector<double> prior_variances(std::span<const FractionPrior> priors) {
  std::vector<double> variances;
  for (const FractionPrior& prior : priors) {
    // The grid of a narrow prior covers only that: one over [0, 1] would be too coarse.
    const double reach = prior.precision > narrow_precision ? reach_sd / std::sqrt(prior.precision) : 1.0;
    const double low = reach < 1.0 ? std::clamp(prior.mean - reach, 0.0, 1.0) : 0.0;
    const double high = reach < 1.0 ? std::clamp(prior.mean + reach, 0.0, 1.0) : 1.0;
    double whole = 0.0, first = 0.0, second = 0.0;
    for (int i = 0; i < prior_grid; ++i) {
      const double u = low + (high - low) * ((i + 0.5) / prior_grid), off = u - prior.mean;
      const double density = exp(-0.5 * prior.precision * off * off);
      whole += density;
      first += density * off;
      second += density * off * off;
    }
    variances.push_back(second / whole - first / whole * (first / whole));
  }
  return variances;
}

std::vector<double> variances_in_range(std::span<const double> truth, std::span<const double> information,
                                       std::span<const FractionPrior> priors, const Random& random) {
  const std::size_t count = truth.size();
  const auto at = [&](std::size_t i, std::size_t j) { return information[triangle(std::max(i, j)) + std::min(i, j)]; };
  std::uint64_t used = 0;
  // Information times the estimate: L truth + L^(1/2) noise.
  std::vector<double> factor(information.begin(), information.end()), pull(count, 0.0);
  if (factorize(count, factor))
    for (std::size_t j = 0; j < count; ++j) {
      const double noise = random.normal(used++);
      for (std::size_t i = j; i < count; ++i) pull[i] += factor[triangle(i) + j] * noise;
    }
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j < count; ++j) pull[i] += at(i, j) * truth[j];
    pull[i] += priors[i].precision * priors[i].mean;
  }
  std::vector<double> precision(information.begin(), information.end());
  for (std::size_t i = 0; i < count; ++i) {
    double& of = precision[triangle(i) + i];
    of = std::max(of + priors[i].precision, min_precision);
  }
  CubeChain chain(std::move(precision), std::move(pull), truth);
  std::vector<double> first(count, 0.0), second(count, 0.0);
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    const std::vector<double>& u = chain.sweep(random, used);
    for (std::size_t i = 0; i < count; ++i) {
      const double off = u[i] - truth[i];
      first[i] += off / sweeps;
      second[i] += off * off / sweeps;
    }
  }
  for (std::size_t i = 0; i < count; ++i) second[i] -= first[i] * first[i];
  return second;
}

}  // namespace decid::posterior
