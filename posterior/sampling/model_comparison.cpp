// Comparison of models: see model_comparison.hpp.
#include "posterior/sampling/model_comparison.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "base/text.hpp"

namespace decid::posterior {
namespace {

constexpr int max_iterations = 10'000;
constexpr double settled = 1e-10;  // the largest change of a weight

/// Returns the weights that maximise sum_i log sum_k w_k p_ki, a concave function, by expectation maximisation.
std::vector<double> stack(std::span<const std::vector<double>> pointwise) {
  const std::size_t models = pointwise.size(), count = pointwise.front().size();
  std::vector<std::vector<double>> density(models, std::vector<double>(count));
  for (std::size_t i = 0; i < count; ++i) {
    double largest = pointwise[0][i];
    for (const std::vector<double>& model : pointwise) largest = std::max(largest, model[i]);
    for (std::size_t k = 0; k < models; ++k) density[k][i] = decid::exp(pointwise[k][i] - largest);
  }
  std::vector<double> weights(models, 1.0 / static_cast<double>(models)), next(models);
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    std::ranges::fill(next, 0.0);
    for (std::size_t i = 0; i < count; ++i) {
      double all = 0.0;
      for (std::size_t k = 0; k < models; ++k) all = std::fma(weights[k], density[k][i], all);
      for (std::size_t k = 0; k < models; ++k)
        next[k] += weights[k] * density[k][i] / (all * static_cast<double>(count));
    }
    double change = 0.0;
    for (std::size_t k = 0; k < models; ++k) change = std::max(change, std::abs(next[k] - weights[k]));
    weights = next;
    if (change < settled) break;
  }
  return weights;
}

}  // namespace

std::vector<ComparedModel> compare_models(std::span<const std::vector<double>> pointwise) {
  const std::size_t count = pointwise.empty() ? 0 : pointwise.front().size();
  if (count < 2 || !std::ranges::all_of(pointwise, [&](const auto& model) { return model.size() == count; }))
    throw Error(Code::size_mismatch, "compare_models",
                format("%zu models with %zu observations", pointwise.size(), count),
                "give models of the same observations, at least 2");
  std::vector<ComparedModel> all(pointwise.size());
  for (std::size_t k = 0; k < all.size(); ++k)
    for (const double value : pointwise[k]) all[k].log_density += value;
  const auto best =
      static_cast<std::size_t>(std::ranges::max_element(all, {}, &ComparedModel::log_density) - all.begin());
  const std::vector<double> weights = stack(pointwise);
  const auto n = static_cast<double>(count);
  for (std::size_t k = 0; k < all.size(); ++k) {
    all[k].weight = weights[k];
    if (k == best) continue;
    all[k].difference = all[k].log_density - all[best].log_density;
    double squares = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
      const double apart = pointwise[k][i] - pointwise[best][i] - all[k].difference / n;
      squares = std::fma(apart, apart, squares);
    }
    all[k].standard_error = std::sqrt(squares * n / (n - 1.0));
  }
  return all;
}

}  // namespace decid::posterior
