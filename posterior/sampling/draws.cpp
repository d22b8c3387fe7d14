// Statistics of draws: see draws.hpp.
#include "posterior/sampling/draws.hpp"

#include <algorithm>
#include <cmath>

namespace decid::posterior {

double mean(std::span<const double> draws) {
  double sum = 0.0;
  for (const double value : draws) sum += value;
  return sum / static_cast<double>(draws.size());
}

double deviation(std::span<const double> draws) {
  const double middle = mean(draws);
  double sum = 0.0;
  for (const double value : draws) sum += (value - middle) * (value - middle);
  return std::sqrt(sum / static_cast<double>(draws.size()));
}

double quantile(std::vector<double> draws, double probability) {
  std::sort(draws.begin(), draws.end());
  return quantile_of_sorted(draws, probability);
}

double quantile_of_sorted(std::span<const double> draws, double probability) {
  const double place = probability * static_cast<double>(draws.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, draws.size() - 1);
  return draws[below] + (place - static_cast<double>(below)) * (draws[above] - draws[below]);
}

double correlation(std::span<const double> a, std::span<const double> b) {
  const double deviations = deviation(a) * deviation(b);
  if (deviations == 0.0) return 0.0;
  const double mean_a = mean(a), mean_b = mean(b);
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - mean_a) * (b[i] - mean_b);
  return sum / static_cast<double>(a.size()) / deviations;
}

}  // namespace decid::posterior
