// Groups compared: see groups.hpp.
#include "identify/groups.hpp"

#include <cmath>
#include <limits>

namespace decid {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr double normal975 = 1.959963984540054;  // quantile of the normal distribution

}  // namespace

GroupSample group_sample(std::span<const double> values) {
  const auto count = static_cast<double>(values.size());
  double sum = 0.0, squares = 0.0;
  for (const double value : values) sum += value;
  const double mean = values.empty() ? unknown : sum / count;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return {values.size(), mean, values.size() > 1 ? std::sqrt(squares / (count - 1.0)) : unknown};
}

GroupEffect group_effect(const GroupSample& first, const GroupSample& second) {
  GroupEffect effect{first.mean - second.mean, unknown, unknown, unknown};
  if (first.count < 2 || second.count < 2) return effect;
  const auto n1 = static_cast<double>(first.count), n2 = static_cast<double>(second.count);
  const double freedom = n1 + n2 - 2.0;
  const double pooled = std::sqrt(
      ((n1 - 1.0) * first.deviation * first.deviation + (n2 - 1.0) * second.deviation * second.deviation) / freedom);
  if (pooled == 0.0) return effect;
  const double d = effect.difference / pooled, correction = 1.0 - 3.0 / (4.0 * freedom - 1.0);
  const double deviation = correction * std::sqrt((n1 + n2) / (n1 * n2) + d * d / (2.0 * (n1 + n2)));
  effect.g = correction * d;
  effect.low = effect.g - normal975 * deviation;
  effect.high = effect.g + normal975 * deviation;
  return effect;
}

}  // namespace decid
