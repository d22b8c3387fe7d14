// Comparison of models: see model_comparison.hpp.
#include "posterior/sampling/model_comparison.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "base/text.hpp"

namespace decid::posterior {
namespace {

constexpr int max_iterations = 100'000;
constexpr double settled = 1e-9;  // change of a weight per iteration

/// Returns the weights that maximise the sum of the logarithms of the mixture's densities, by expectation and
/// maximisation, whose steps cannot leave the simplex.
std::vector<double> stacking_weights(std::span<const std::vector<double>> pointwise) {
  const std::size_t models = pointwise.size(), count = pointwise.front().size();
  std::vector<double> density(models * count);  // over the largest of the observation
  for (std::size_t i = 0; i < count; ++i) {
    double largest = pointwise.front()[i];
    for (const std::vector<double>& model : pointwise) largest = std::max(largest, model[i]);
    for (std::size_t k = 0; k < models; ++k) density[i * models + k] = decid::exp(pointwise[k][i] - largest);
  }
  std::vector<double> weights(models, 1.0 / static_cast<double>(models)), next(models);
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    std::fill(next.begin(), next.end(), 0.0);
    for (std::size_t i = 0; i < count; ++i) {
      double mixture = 0.0;
      for (std::size_t k = 0; k < models; ++k) mixture += weights[k] * density[i * models + k];
      for (std::size_t k = 0; k < models; ++k)
        next[k] += weights[k] * density[i * models + k] / mixture / static_cast<double>(count);
    }
    double change = 0.0;
    for (std::size_t k = 0; k < models; ++k) change = std::max(change, std::abs(next[k] - weights[k]));
    weights.swap(next);
    if (change < settled) break;
  }
  return weights;
}

void check(std::span<const std::vector<double>> pointwise) {
  const std::size_t count = pointwise.empty() ? 0 : pointwise.front().size();
  if (count < 2)
    throw Error("compare_models", format("%zu models of %zu observations", pointwise.size(), count),
                "give at least one model and 2 observations");
  for (const std::vector<double>& model : pointwise) {
    if (model.size() != count)
      throw Error("compare_models", format("models of %zu and %zu observations", count, model.size()),
                  "give all models the same observations");
    if (!std::ranges::all_of(model, [](double value) { return std::isfinite(value); }))
      throw Error("compare_models", "has values that are not finite", "give logarithms of densities");
  }
}

}  // namespace

std::vector<ComparedModel> compare_models(std::span<const std::vector<double>> pointwise) {
  check(pointwise);
  const auto count = static_cast<double>(pointwise.front().size());
  std::vector<ComparedModel> compared(pointwise.size());
  for (std::size_t k = 0; k < compared.size(); ++k)
    for (const double value : pointwise[k]) compared[k].log_density += value;
  const auto best =
      static_cast<std::size_t>(std::ranges::max_element(compared, {}, &ComparedModel::log_density) - compared.begin());
  const std::vector<double> weights = stacking_weights(pointwise);
  for (std::size_t k = 0; k < compared.size(); ++k) {
    compared[k].difference = compared[k].log_density - compared[best].log_density;
    double squares = 0.0;
    for (std::size_t i = 0; i < pointwise[k].size(); ++i) {
      const double off = pointwise[k][i] - pointwise[best][i] - compared[k].difference / count;
      squares += off * off;
    }
    compared[k].standard_error = std::sqrt(squares * count / (count - 1.0));
    compared[k].weight = weights[k];
  }
  return compared;
}

}  // namespace decid::posterior
