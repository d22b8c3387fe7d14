// Statistics of values in memory: see statistics.hpp.
#include "base/math/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace decid {
namespace {

template <class T>
double mean_in_double(std::span<const T> values) {
  double sum = 0.0;
  for (const T value : values) sum += static_cast<double>(value);
  return sum / static_cast<double>(values.size());
}

double squares_about_mean(std::span<const double> values) {
  const double middle = mean(values);
  double sum = 0.0;
  for (const double value : values) sum += (value - middle) * (value - middle);
  return sum;
}

}  // namespace

double mean(std::span<const double> values) {
  return mean_in_double(values);
}

double mean(std::span<const float> values) {
  return mean_in_double(values);
}

void subtract_mean(std::span<double> values) {
  const double middle = mean(values);
  for (double& value : values) value -= middle;
}

double stddev(std::span<const double> values) {
  return std::sqrt(squares_about_mean(values) / static_cast<double>(values.size()));
}

double sample_variance(std::span<const double> values) {
  return squares_about_mean(values) / static_cast<double>(values.size() - 1);
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::ranges::nth_element(values, middle);
  return *middle;
}

double stddev_by_median(std::vector<double> sizes) {
  return median(std::move(sizes)) / 0.6745;
}

double quantile(std::vector<double> values, double fraction) {
  std::ranges::sort(values);
  return quantile_of_sorted(values, fraction);
}

double quantile_of_sorted(std::span<const double> values, double fraction) {
  const double place = fraction * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (place - static_cast<double>(below)) * (values[above] - values[below]);
}

double correlation(std::span<const double> a, std::span<const double> b) {
  const double scale = stddev(a) * stddev(b);
  if (scale == 0.0) return 0.0;
  const double mean_a = mean(a), mean_b = mean(b);
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - mean_a) * (b[i] - mean_b);
  return sum / static_cast<double>(a.size()) / scale;
}

double hedges_g(double difference, double sd, double degrees_of_freedom) {
  if (sd == 0.0 || degrees_of_freedom < 2.0) return std::numeric_limits<double>::quiet_NaN();
  return (1.0 - 3.0 / (4.0 * degrees_of_freedom - 1.0)) * difference / sd;
}

}  // namespace decid
