// Normal posteriors within ranges: see bounded_normal.hpp.
#include "posterior/planning/bounded_normal.hpp"

#include <algorithm>
#include <cmath>

#include "base/math/cholesky.hpp"
#include "base/math/math.hpp"

namespace decid::posterior {
namespace {

constexpr int sweeps = 1000, prior_grid = 400;
constexpr double min_precision = 1e-6;  // of a fraction: nothing is known
constexpr double narrow_precision = 1e4, reach_sd = 8.0;

/// Returns the quantile of a normal distribution within [0, 1]. Far outside of it the nearer end is the quantile.
double quantile_in_range(double mean, double sd, double probability) {
  const double low = normal_distribution(-mean / sd), high = normal_distribution((1.0 - mean) / sd);
  const double within = low + probability * (high - low);
  if (!(high > low && within > 0.0 && within < 1.0)) return std::clamp(mean, 0.0, 1.0);
  return std::clamp(mean + sd * inverse_normal(within), 0.0, 1.0);
}

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
  std::vector<double> u(truth.begin(), truth.end()), first(count, 0.0), second(count, 0.0);
  for (int sweep = 0; sweep < sweeps; ++sweep)
    for (std::size_t i = 0; i < count; ++i) {
      double sum = pull[i];
      for (std::size_t j = 0; j < count; ++j) sum -= i == j ? 0.0 : at(i, j) * u[j];
      const double precision = std::max(at(i, i) + priors[i].precision, min_precision);
      u[i] = quantile_in_range(sum / precision, 1.0 / std::sqrt(precision), random.uniform(used++));
      const double off = u[i] - truth[i];
      first[i] += off / sweeps;
      second[i] += off * off / sweeps;
    }
  for (std::size_t i = 0; i < count; ++i) second[i] -= first[i] * first[i];
  return second;
}

}  // namespace decid::posterior
