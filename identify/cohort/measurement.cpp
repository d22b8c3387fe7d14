// Evidence of recordings: see measurement.hpp.
#include "identify/cohort/measurement.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/math/cholesky.hpp"
#include "base/math/math.hpp"
#include "base/math/random.hpp"
#include "base/text.hpp"

namespace decid::cohort {
namespace {

constexpr double range_end = 1e-6;     // fractions of a range nearer to an end count as this
constexpr double min_variance = 1e-8;  // of a coordinate
constexpr double max_variance = 0.99;  // of a coordinate under its prior, for the variance of its evidence

/// Returns A^-1 of a lower triangle, and half the logarithm of its determinant.
struct Inverse {
  std::vector<double> matrix;
  double half_log_determinant = 0.0;
};
Inverse inverse_of(std::size_t size, std::vector<double> matrix) {
  if (!factorize(size, matrix))
    throw Error(Code::value_invalid, "cohort", "the parameters of a recording are perfectly correlated",
                "leave the recording out");
  Inverse result{std::vector<double>(matrix.size()), 0.0};
  invert_lower(size, matrix);
  for (std::size_t i = 0; i < size; ++i) {
    result.half_log_determinant += log(matrix[triangle(i) + i]);
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = 0.0;
      for (std::size_t k = i; k < size; ++k) sum = std::fma(matrix[triangle(k) + i], matrix[triangle(k) + j], sum);
      result.matrix[triangle(i) + j] = sum;
    }
  }
  return result;
}

/// Brings every variance of a covariance to at most 1, the prior's: rotates to its axes (Jacobi), cuts, rotates back.
/// A component wider than the prior would be evidence of negative precision.
void cut_at_prior(std::size_t size, std::vector<double>& covariance) {
  std::vector<double> a(size * size), axes(size * size, 0.0);
  for (std::size_t i = 0; i < size; ++i) {
    axes[i * size + i] = 1.0;
    for (std::size_t j = 0; j < size; ++j) a[i * size + j] = covariance[triangle(std::max(i, j)) + std::min(i, j)];
  }
  const auto rotate = [](double& one, double& other, double c, double s) {
    const double before = one;
    one = c * before - s * other;
    other = s * before + c * other;
  };
  for (int sweep = 0; sweep < 30; ++sweep) {
    double off = 0.0;
    for (std::size_t i = 0; i < size; ++i)
      for (std::size_t j = 0; j < i; ++j) off += a[i * size + j] * a[i * size + j];
    if (off < 1e-24) break;
    for (std::size_t p = 0; p < size; ++p)
      for (std::size_t q = p + 1; q < size; ++q) {
        if (std::abs(a[p * size + q]) < 1e-300) continue;
        const double turn = (a[q * size + q] - a[p * size + p]) / (2.0 * a[p * size + q]);
        const double t = (turn >= 0.0 ? 1.0 : -1.0) / (std::abs(turn) + std::sqrt(turn * turn + 1.0));
        const double c = 1.0 / std::sqrt(t * t + 1.0), s = t * c;
        for (std::size_t k = 0; k < size; ++k) rotate(a[k * size + p], a[k * size + q], c, s);
        for (std::size_t k = 0; k < size; ++k) rotate(a[p * size + k], a[q * size + k], c, s);
        for (std::size_t k = 0; k < size; ++k) rotate(axes[k * size + p], axes[k * size + q], c, s);
      }
  }
  for (std::size_t i = 0; i < size; ++i)
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = 0.0;
      for (std::size_t k = 0; k < size; ++k)
        sum += axes[i * size + k] * std::clamp(a[k * size + k], min_variance, 1.0) * axes[j * size + k];
      covariance[triangle(i) + j] = sum;
    }
}

void check_draws(std::size_t parameters, std::span<const double> fractions, std::span<const double> log_weights) {
  const std::size_t draws = parameters > 0 ? fractions.size() / parameters : 0;
  if (draws < 16 || draws * parameters != fractions.size() || (!log_weights.empty() && log_weights.size() != draws))
    throw Error(Code::size_mismatch, "cohort",
                format("a recording has %zu values for %zu parameters, and %zu weights", fractions.size(), parameters,
                       log_weights.size()),
                "give at least 16 draws, all parameters each, and no weights or one per draw");
  const auto finite = [](double value) { return std::isfinite(value); };
  if (!std::ranges::all_of(fractions, finite) || !std::ranges::all_of(log_weights, finite))
    throw Error(Code::value_invalid, "cohort", "a draw is not finite", "leave the recording out");
}

}  // namespace

/// Cuts every component at the prior. The variance of a coordinate's evidence is the whole mixture's, without the
/// prior.
Measurement::Measurement(Gaussians gaussians) : parameters_(gaussians.centres.front().size()) {
  std::vector<double> mean(parameters_, 0.0), variance(parameters_, 0.0);
  centres_ = std::move(gaussians.centres);
  for (std::size_t k = 0; k < centres_.size(); ++k)
    for (std::size_t p = 0; p < parameters_; ++p) mean[p] += gaussians.weights[k] * centres_[k][p];
  for (std::size_t k = 0; k < centres_.size(); ++k) {
    std::vector<double>& covariance = gaussians.covariances[k];
    cut_at_prior(parameters_, covariance);
    for (std::size_t p = 0; p < parameters_; ++p) {
      const double off = centres_[k][p] - mean[p];
      variance[p] += gaussians.weights[k] * (covariance[triangle(p) + p] + off * off);
    }
    Inverse inverse = inverse_of(parameters_, std::move(covariance));
    log_weights_.push_back(log(std::max(gaussians.weights[k], 1e-300)) + inverse.half_log_determinant);
    precisions_.push_back(std::move(inverse.matrix));
  }
  for (const double value : variance) {
    const double below_prior = std::min(value, max_variance);
    variances_.push_back(below_prior / (1.0 - below_prior));
  }
}

Measurement Measurement::of_draws(std::size_t parameters, std::span<const double> fractions,
                                  std::span<const double> log_weights, std::optional<double> effective_draws) {
  check_draws(parameters, fractions, log_weights);
  const std::size_t draws = fractions.size() / parameters, count = std::min(draws, max_draws);
  std::vector<double> weights(count, 1.0), points;
  const double highest = log_weights.empty() ? 0.0 : *std::ranges::max_element(log_weights);
  double whole = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t draw = i * draws / count;
    if (!log_weights.empty()) weights[i] = exp(log_weights[draw] - highest);
    whole += weights[i];
    for (const double fraction : fractions.subspan(draw * parameters, parameters))
      points.push_back(inverse_normal(std::clamp(fraction, range_end, 1.0 - range_end)));
  }
  double squares = 0.0;
  for (double& weight : weights) {
    weight /= whole;
    squares += weight * weight;
  }
  const double weighted = 1.0 / squares;
  if (!log_weights.empty() && weighted < std::min(min_weighted_draws, 0.5 * static_cast<double>(count)))
    throw Error(Code::value_invalid, "cohort",
                format("a recording's prior leaves %.0f of %zu draws with weight", weighted, count),
                "leave the recording out, or fit it with a wider prior");
  double effective = std::min(weighted, effective_draws.value_or(weighted));
  if (!log_weights.empty()) {  // weights and dependence both take draws away
    const auto used = static_cast<double>(count);
    effective = std::min(effective_draws.value_or(used), used) * weighted / used;
  }
  Gaussians gaussians = fit_gaussians(parameters, points, weights, effective, min_variance);
  for (std::size_t k = 0; k < gaussians.weights.size(); ++k) {
    const double here = gaussians.weights[k] * effective;
    const double fewer = std::max(here - static_cast<double>(parameters) - 2.0, 0.25 * here);
    for (double& one : gaussians.covariances[k]) one *= here / fewer;
  }
  return Measurement(std::move(gaussians));
}

Measurement Measurement::of_distribution(const ParameterDistribution& distribution) {
  const Mixture& mixture = distribution.mixture();
  const std::size_t parameters = mixture.parameters();
  Gaussians gaussians;
  std::vector<double> mean(parameters, 0.0);
  for (std::size_t k = 0; k < mixture.components(); ++k)
    for (std::size_t p = 0; p < parameters; ++p) mean[p] += mixture.weight(k) * mixture.centre(k)[p];
  for (std::size_t k = 0; k < mixture.components(); ++k) {
    std::vector<double>& centre = gaussians.centres.emplace_back();
    std::vector<double>& covariance = gaussians.covariances.emplace_back();
    gaussians.weights.push_back(mixture.weight(k));
    for (std::size_t p = 0; p < parameters; ++p) {
      const double factor = distribution.recalibration().factor(p);
      centre.push_back(mean[p] + factor * (mixture.centre(k)[p] - mean[p]));
      for (std::size_t q = 0; q <= p; ++q)
        covariance.push_back(factor * distribution.recalibration().factor(q) *
                             mixture.covariance(k)[p * parameters + q]);
    }
  }
  return Measurement(std::move(gaussians));
}

}  // namespace decid::cohort
