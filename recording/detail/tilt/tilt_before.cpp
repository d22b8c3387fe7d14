// The platform's movement before the protocol's start: see tilt_before.hpp.
#include "recording/detail/tilt/tilt_before.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/math/statistics.hpp"

namespace decid::recording {
namespace {

constexpr double min_before_s = 1.0, max_before_s = 10.0;
constexpr double rest_fraction = 0.01;     // of the protocol's tilt, variances
constexpr double noise_fraction = 0.5;     // of the measurement noise: its variance over one second is known to 14%
constexpr double alike_correlation = 0.9;  // correlation

double covariance(std::span<const double> a, std::span<const double> b) {
  const double mean_a = mean(a), mean_b = mean(b);
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - mean_a) * (b[i] - mean_b);
  return sum / static_cast<double>(a.size());
}

/// Returns the variance, from `first` on, that the protocol's tilt does not explain.
double noise_variance(std::span<const double> measured, std::size_t first, std::span<const double> expected,
                      double gain) {
  std::vector<double> rest;
  for (std::size_t i = 0; i < expected.size() && first + i < measured.size(); ++i)
    rest.push_back(measured[first + i] - gain * expected[i]);
  return rest.empty() ? 0.0 : covariance(rest, rest);
}

}  // namespace

TiltBefore tilt_before(std::span<const double> measured, double start, std::span<const double> expected, double gain,
                       double rate_hz) {
  const double samples =
      std::min({std::floor(start + 0.5), max_before_s * rate_hz, static_cast<double>(expected.size())});
  if (samples < min_before_s * rate_hz) return TiltBefore::unknown;
  const auto count = static_cast<std::size_t>(samples);
  const auto first = static_cast<std::size_t>(std::floor(start + 0.5));
  const std::span<const double> before = measured.subspan(first - count, count);
  const std::span<const double> end = expected.last(count);
  const double noise = noise_variance(measured, first, expected, gain);
  const double moved = covariance(before, before) - noise, of_end = covariance(end, end);
  const double of_protocol = gain * gain * covariance(expected, expected);
  if (moved <= rest_fraction * of_protocol + noise_fraction * noise) return TiltBefore::at_rest;
  const bool follows = of_end > 0.0 && covariance(before, end) >= alike_correlation * std::sqrt(moved * of_end);
  return follows ? TiltBefore::cycle_end : TiltBefore::another_tilt;
}

}  // namespace decid::recording
