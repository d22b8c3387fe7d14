// Comparison of models: see model_comparison.hpp.
#include "posterior/sampling/model_comparison.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "base/text.hpp"

namespace decid::posterior {
namespace {

constexpr int max_sweeps = 1000, halvings = 60;
constexpr double settled = 1e-7;  // in nats, below the maximum

/// Densities of observations by models, and the weights of a mixture that predicts them.
class Mixture {
 public:
  explicit Mixture(std::span<const std::vector<double>> pointwise)
      : count_(pointwise.front().size()),
        density_(pointwise.size(), std::vector<double>(count_)),
        weights_(pointwise.size(), 1.0 / static_cast<double>(pointwise.size())) {
    for (std::size_t i = 0; i < count_; ++i) {
      double largest = pointwise[0][i];
      for (const std::vector<double>& model : pointwise) largest = std::max(largest, model[i]);
      for (std::size_t k = 0; k < density_.size(); ++k) density_[k][i] = decid::exp(pointwise[k][i] - largest);
    }
  }

  /// Returns the weights that maximise sum_i log sum_k w_k p_ki, a concave function: one pair of models after the
  /// other shares its weights again, until no change of weights can gain `settled`.
  std::vector<double> stack() {
    for (int sweep = 0; sweep < max_sweeps && !is_settled(); ++sweep)
      for (std::size_t k = 1; k < density_.size(); ++k)
        for (std::size_t j = 0; j < k; ++j) share(j, k);
    return weights_;
  }

 private:
  double mixed(std::size_t i) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < density_.size(); ++k) sum = std::fma(weights_[k], density_[k][i], sum);
    return sum;
  }

  /// The maximum is at most the largest derivative by a weight less the number of observations higher.
  bool is_settled() const {
    double steepest = 0.0;
    for (const std::vector<double>& density : density_) {
      double sum = 0.0;
      for (std::size_t i = 0; i < count_; ++i) sum += density[i] / mixed(i);
      steepest = std::max(steepest, sum);
    }
    return steepest - static_cast<double>(count_) <= settled;
  }

  /// Shares the weight of models j and k between them by halving the interval that has the maximum.
  void share(std::size_t j, std::size_t k) {
    const double both = weights_[j] + weights_[k];
    const auto rises = [&](double weight) {
      weights_[k] = weight;
      weights_[j] = both - weight;
      double slope = 0.0;
      for (std::size_t i = 0; i < count_; ++i) {
        const double difference = density_[k][i] - density_[j][i];
        if (difference != 0.0) slope += difference / mixed(i);
      }
      return slope > 0.0;
    };
    if (!rises(0.0)) return;
    if (rises(both)) return;
    double low = 0.0, high = both;
    for (int i = 0; i < halvings; ++i) {
      const double middle = 0.5 * (low + high);
      (rises(middle) ? low : high) = middle;
    }
  }

  std::size_t count_;
  std::vector<std::vector<double>> density_;  // by model, over the likeliest model's
  std::vector<double> weights_;
};

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
  const std::vector<double> weights = Mixture(pointwise).stack();
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
