// Leave-one-out cross-validation: see leave_one_out.hpp.
#include "posterior/sampling/leave_one_out.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "base/text.hpp"

namespace decid::posterior {
namespace {

constexpr std::size_t min_draws = 25;

/// Returns log(sum exp(values)).
double log_sum(std::span<const double> values) {
  const double largest = *std::ranges::max_element(values);
  double sum = 0.0;
  for (const double value : values) sum += decid::exp(value - largest);
  return largest + decid::log(sum);
}

/// P(X > x) = (1 + shape x / scale)^(-1 / shape).
struct GeneralizedPareto {
  double shape, scale;

  double quantile(double probability) const {
    const double power = -decid::log(1.0 - probability);
    return std::abs(shape) < 1e-9 ? scale * power : scale * (decid::exp(shape * power) - 1.0) / shape;
  }
};

double mean_log(double theta, std::span<const double> x) {
  double sum = 0.0;
  for (const double value : x) sum += decid::log(1.0 - theta * value);
  return sum / static_cast<double>(x.size());
}

/// Returns the value at the first quarter of ascending ones.
double quarter_of(std::span<const double> x) {
  return x[(2 * x.size() + 4) / 8 - 1];
}

/// Fits to x >= 0, ascending, with quarter_of(x) > 0. Averages theta = -shape / scale over its profile likelihood;
/// shrinks the shape towards 1/2, with the weight of ten values.
GeneralizedPareto fit(std::span<const double> x) {
  const auto count = static_cast<double>(x.size());
  const double quarter = quarter_of(x);
  const int tried = 30 + static_cast<int>(std::sqrt(count));
  std::vector<double> theta, likelihood;
  for (int j = 0; j < tried; ++j) {
    const double place = 1.0 / x.back() + (1.0 - std::sqrt(tried / (j + 0.5))) / (3.0 * quarter);
    const double shape = mean_log(place, x);
    theta.push_back(place);
    likelihood.push_back(count * (decid::log(-place / shape) - shape - 1.0));
  }
  const double all = log_sum(likelihood);
  double middle = 0.0;
  for (std::size_t j = 0; j < theta.size(); ++j) middle += theta[j] * decid::exp(likelihood[j] - all);
  const double shape = mean_log(middle, x);
  return {(count * shape + 5.0) / (count + 10.0), -shape / middle};
}

/// Returns true if the weights count for less than a tenth of the draws: (sum w)^2 / sum w^2.
bool few_dominate(std::span<const double> log_weights) {
  double sum = 0.0, squares = 0.0;
  for (const double weight : log_weights) {
    const double w = decid::exp(weight);
    sum += w;
    squares += w * w;
  }
  return sum * sum < 0.1 * static_cast<double>(log_weights.size()) * squares;
}

/// Replaces the largest log weights by quantiles of the fitted distribution, limited to the largest. Returns its shape.
/// Where a quarter of the tail is as large as the rest, none fits: 0, or infinity if few draws dominate.
double smooth(std::vector<double>& log_weights) {
  const double largest = *std::ranges::max_element(log_weights);
  for (double& weight : log_weights) weight -= largest;
  std::vector<std::size_t> order(log_weights.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return log_weights[i]; });
  const auto draws = static_cast<double>(order.size());
  const auto tail = static_cast<std::size_t>(std::ceil(std::min(0.2 * draws, 3.0 * std::sqrt(draws))));
  const std::span<const std::size_t> last = std::span(order).last(tail);
  const double cut = decid::exp(log_weights[order[order.size() - tail - 1]]);
  std::vector<double> beyond;
  for (const std::size_t i : last) beyond.push_back(decid::exp(log_weights[i]) - cut);
  if (!(quarter_of(beyond) > 1e-12 * beyond.back()))
    return few_dominate(log_weights) ? std::numeric_limits<double>::infinity() : 0.0;
  const GeneralizedPareto found = fit(beyond);
  for (std::size_t j = 0; j < tail; ++j) {
    const double probability = (static_cast<double>(j) + 0.5) / static_cast<double>(tail);
    log_weights[last[j]] = std::min(0.0, decid::log(cut + found.quantile(probability)));
  }
  return found.shape;
}

}  // namespace

LeaveOneOut leave_one_out(std::span<const double> log_likelihood, int observations) {
  const std::size_t count = observations > 1 ? static_cast<std::size_t>(observations) : 0;
  const std::size_t draws = count > 0 ? log_likelihood.size() / count : 0;
  if (draws < min_draws || log_likelihood.size() != draws * count)
    throw Error(Code::size_mismatch, "leave_one_out",
                format("%zu values for %d observations", log_likelihood.size(), observations),
                format("give at least 2 observations, and at least %zu draws of each", min_draws));
  if (!std::ranges::all_of(log_likelihood, [](double value) { return std::isfinite(value); }))
    throw Error(Code::value_invalid, "leave_one_out", "has values that are not finite",
                "give logarithms of likelihoods");
  const double limit = std::min(1.0 - decid::log(10.0) / decid::log(static_cast<double>(draws)), 0.7);
  LeaveOneOut result;
  result.max_reliable_shape = limit;
  std::vector<double>& each = result.pointwise;
  std::vector<double> of(draws), weights(draws);
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t draw = 0; draw < draws; ++draw) of[draw] = log_likelihood[draw * count + i];
    std::ranges::transform(of, weights.begin(), [](double value) { return -value; });
    const double shape = smooth(weights);
    const double seen = log_sum(of) - decid::log(static_cast<double>(draws)), all = log_sum(weights);
    for (std::size_t draw = 0; draw < draws; ++draw) of[draw] += weights[draw];
    each.push_back(log_sum(of) - all);
    result.log_density += each.back();
    result.effective_parameters += seen - each.back();
    result.max_shape = i == 0 ? shape : std::max(result.max_shape, shape);
    result.unreliable += shape > limit ? 1 : 0;
    result.shapes.push_back(shape);
  }
  double squares = 0.0;
  const double mean = result.log_density / static_cast<double>(count);
  for (const double value : each) squares += (value - mean) * (value - mean);
  result.standard_error = std::sqrt(squares * static_cast<double>(count) / static_cast<double>(count - 1));
  return result;
}

}  // namespace decid::posterior
