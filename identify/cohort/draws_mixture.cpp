// Gaussians fitted to draws: see draws_mixture.hpp.
#include "identify/cohort/draws_mixture.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/math/cholesky.hpp"
#include "base/math/math.hpp"

namespace decid::cohort {
namespace {

constexpr int trial_steps = 3, max_steps = 40;
constexpr double converged = 1e-4;  // gain of the mean log density per step

class DrawsFit {
 public:
  DrawsFit(std::size_t size, std::span<const double> points, std::span<const double> weights, double effective_draws,
           double min_variance)
      : size_(size), points_(points), weights_(weights), draws_(effective_draws), min_variance_(min_variance) {}

  struct Found {
    Gaussians gaussians;
    double log_density = 0.0;  ///< mean over the draws
  };

  Gaussians one() {
    Gaussians result{{1.0}, {std::vector<double>(size_)}, {std::vector<double>(triangle(size_))}};
    parts_.assign(1, std::vector<double>(weights_.begin(), weights_.end()));
    maximise(result);
    return result;
  }
  /// Returns the best of the mixtures with one component split; empty if all have a component of too few draws.
  std::optional<Found> with_one_more(const Gaussians& gaussians) {
    std::optional<Found> best;
    for (std::size_t k = 0; k < gaussians.weights.size(); ++k)
      for (std::size_t p = 0; p < size_; ++p)
        if (std::optional<Found> found = climb(split(gaussians, k, p), trial_steps);
            found && (!best || found->log_density > best->log_density))
          best = std::move(found);
    return best ? climb(best->gaussians, max_steps) : best;
  }
  std::optional<double> log_density(const Gaussians& gaussians) { return expect(gaussians); }
  /// Returns Schwarz's criterion, up to the factor -2.
  double worth(double log_density, std::size_t components) const {
    const auto numbers = static_cast<double>(components * (1 + size_ + triangle(size_)) - 1);
    return draws_ * log_density - 0.5 * numbers * log(draws_);
  }

 private:
  /// Splits component k along the regression on coordinate p; mean and covariance stay.
  Gaussians split(const Gaussians& gaussians, std::size_t k, std::size_t p) const {
    constexpr double apart = 0.8;
    Gaussians result = gaussians;
    const std::vector<double> whole = gaussians.covariances[k];
    const auto along = [&](std::size_t i) {
      return apart * whole[triangle(std::max(i, p)) + std::min(i, p)] / std::sqrt(whole[triangle(p) + p]);
    };
    for (std::size_t i = 0; i < size_; ++i)
      for (std::size_t j = 0; j <= i; ++j) result.covariances[k][triangle(i) + j] -= along(i) * along(j);
    result.weights[k] *= 0.5;
    result.weights.push_back(result.weights[k]);
    result.centres.push_back(result.centres[k]);
    result.covariances.push_back(result.covariances[k]);
    for (std::size_t i = 0; i < size_; ++i) {
      result.centres[k][i] -= along(i);
      result.centres.back()[i] += along(i);
    }
    return result;
  }

  std::optional<Found> climb(Gaussians gaussians, int steps) {
    double last = -INFINITY;
    for (int step = 0; step < steps; ++step) {
      const std::optional<double> here = expect(gaussians);
      if (!here || !maximise(gaussians)) return std::nullopt;
      if (*here - last < converged) break;
      last = *here;
    }
    const std::optional<double> here = expect(gaussians);
    if (!here) return std::nullopt;
    return Found{std::move(gaussians), *here};
  }

  /// Sets parts_ to every draw's weight in each component. Returns the mean log density; empty if a covariance is
  /// singular.
  std::optional<double> expect(const Gaussians& gaussians) {
    const std::size_t components = gaussians.weights.size(), count = weights_.size();
    parts_.assign(components, std::vector<double>(count));
    std::vector<double> off(size_);
    for (std::size_t k = 0; k < components; ++k) {
      std::vector<double> root = gaussians.covariances[k];
      if (!factorize(size_, root)) return std::nullopt;
      invert_lower(size_, root);
      double constant = log(gaussians.weights[k]);
      for (std::size_t i = 0; i < size_; ++i) constant += log(root[triangle(i) + i]);
      for (std::size_t n = 0; n < count; ++n) {
        double sum = 0.0;
        for (std::size_t i = 0; i < size_; ++i) off[i] = points_[n * size_ + i] - gaussians.centres[k][i];
        for (std::size_t i = 0; i < size_; ++i) {
          double value = 0.0;
          for (std::size_t j = 0; j <= i; ++j) value += root[triangle(i) + j] * off[j];
          sum += value * value;
        }
        parts_[k][n] = constant - 0.5 * sum;
      }
    }
    double all = 0.0;
    for (std::size_t n = 0; n < count; ++n) {
      double highest = -INFINITY, whole = 0.0;
      for (const std::vector<double>& part : parts_) highest = std::max(highest, part[n]);
      for (std::vector<double>& part : parts_) whole += part[n] = exp(part[n] - highest);
      for (std::vector<double>& part : parts_) part[n] *= weights_[n] / whole;
      all += weights_[n] * (highest + log(whole));
    }
    return all;
  }

  /// Returns false if a component has too few draws for its covariance.
  bool maximise(Gaussians& gaussians) const {
    for (std::size_t k = 0; k < parts_.size(); ++k) {
      double whole = 0.0;
      for (const double part : parts_[k]) whole += part;
      if (parts_.size() > 1 && whole * draws_ < 4.0 * static_cast<double>(size_ + 1)) return false;
      gaussians.weights[k] = whole;
      std::vector<double>&centre = gaussians.centres[k], &covariance = gaussians.covariances[k];
      std::ranges::fill(centre, 0.0);
      std::ranges::fill(covariance, 0.0);
      for (std::size_t n = 0; n < weights_.size(); ++n) {
        const double part = parts_[k][n] / whole;
        for (std::size_t i = 0; i < size_; ++i) centre[i] += part * points_[n * size_ + i];
      }
      std::vector<double> off(size_);
      for (std::size_t n = 0; n < weights_.size(); ++n) {
        const double part = parts_[k][n] / whole;
        double* value = covariance.data();
        for (std::size_t i = 0; i < size_; ++i) off[i] = points_[n * size_ + i] - centre[i];
        for (std::size_t i = 0; i < size_; ++i)
          for (std::size_t j = 0; j <= i; ++j) *value++ += part * off[i] * off[j];
      }
      for (std::size_t i = 0; i < size_; ++i) {
        double& variance = covariance[triangle(i) + i];
        variance = std::max(variance * (1.0 + 1e-9), min_variance_);
      }
    }
    return true;
  }

  std::size_t size_;
  std::span<const double> points_, weights_;
  double draws_, min_variance_;               ///< draws_: their effective number
  std::vector<std::vector<double>> parts_{};  ///< component by component
};

}  // namespace

Gaussians fit_gaussians(std::size_t size, std::span<const double> points, std::span<const double> weights,
                        double effective_draws, double min_variance) {
  DrawsFit fit(size, points, weights, effective_draws, min_variance);
  Gaussians best = fit.one();
  const std::optional<double> single = fit.log_density(best);
  if (!single) return best;
  double worth = fit.worth(*single, 1);
  while (best.weights.size() < max_gaussians) {
    std::optional<DrawsFit::Found> found = fit.with_one_more(best);
    if (!found || !(fit.worth(found->log_density, best.weights.size() + 1) > worth)) break;
    worth = fit.worth(found->log_density, best.weights.size() + 1);
    best = std::move(found->gaussians);
  }
  return best;
}

}  // namespace decid::cohort
