// What the platform did before the protocol's start: see tilt_before.hpp.
#include "dataset/recording/tilt_before.hpp"

#include <algorithm>
#include <cmath>

namespace decid::dataset {
namespace {

constexpr double least_before_s = 1.0, most_before_s = 10.0;
constexpr double at_rest_share = 0.1;      // of the protocol's tilt, standard deviations
constexpr double alike_correlation = 0.9;  // correlation

double mean(std::span<const double> values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

double covariance(std::span<const double> a, std::span<const double> b) {
  const double mean_a = mean(a), mean_b = mean(b);
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - mean_a) * (b[i] - mean_b);
  return sum / static_cast<double>(a.size());
}

}  // namespace

TiltBefore tilt_before(std::span<const double> measured, double start, std::span<const double> expected, double gain,
                       double rate_hz) {
  const double samples =
      std::min({std::floor(start + 0.5), most_before_s * rate_hz, static_cast<double>(expected.size())});
  if (samples < least_before_s * rate_hz) return TiltBefore::unknown;
  const auto count = static_cast<std::size_t>(samples);
  const std::span<const double> before =
      measured.subspan(static_cast<std::size_t>(std::floor(start + 0.5)) - count, count);
  const std::span<const double> end = expected.last(count);
  const double moved = covariance(before, before), of_end = covariance(end, end);
  const double of_protocol = gain * gain * covariance(expected, expected);
  if (moved <= at_rest_share * at_rest_share * of_protocol) return TiltBefore::at_rest;
  const bool follows = of_end > 0.0 && covariance(before, end) >= alike_correlation * std::sqrt(moved * of_end);
  return follows ? TiltBefore::cycle_end : TiltBefore::another_tilt;
}

}  // namespace decid::dataset
