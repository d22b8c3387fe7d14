// Cross-correlation by FFT, normalised by the measured tilt's deviation in each window: see tilt_match.hpp.
#include "dataset/recording/tilt_match.hpp"

#include <algorithm>
#include <cmath>

#include "sim/fft.hpp"

namespace decid::dataset {

namespace {

/// Of a constant signal's squares, what may be left by rounding when its mean is taken off: 1e-10 of its size, squared.
constexpr double still = 1e-20;

}  // namespace

Match match_tilt(std::span<const double> measured, std::span<const double> expected, int overhang) {
  const std::size_t n = expected.size(), over = static_cast<std::size_t>(overhang);
  std::vector<double> held(over, measured.front());
  held.insert(held.end(), measured.begin(), measured.end());
  held.insert(held.end(), over, measured.back());
  if (n == 0 || held.size() < n) return {};
  const std::size_t delays = held.size() - n + 1;

  // Means are subtracted first, so that the sums of squares below are differences of numbers of their own size.
  double held_mean = 0.0, expected_mean = 0.0;
  for (const double value : held) held_mean += value / static_cast<double>(held.size());
  for (const double value : expected) expected_mean += value / static_cast<double>(n);
  int length = 2;
  while (static_cast<std::size_t>(length) < held.size() + n) length *= 2;
  const sim::RealFft fft(length);
  std::vector<double> a(static_cast<std::size_t>(length), 0.0), b(a.size(), 0.0);
  double energy = 0.0, held_size = 0.0, expected_size = 0.0;
  for (std::size_t k = 0; k < held.size(); ++k) {
    a[k] = held[k] - held_mean;
    held_size += held[k] * held[k];
  }
  for (std::size_t k = 0; k < n; ++k) {
    b[k] = expected[k] - expected_mean;
    energy += b[k] * b[k];
    expected_size += expected[k] * expected[k];
  }
  std::vector<double> sum(held.size() + 1, 0.0), squares(held.size() + 1, 0.0);
  for (std::size_t k = 0; k < held.size(); ++k) {
    sum[k + 1] = sum[k] + a[k];
    squares[k + 1] = squares[k] + a[k] * a[k];
  }
  if (energy <= still * expected_size || squares.back() <= still * held_size) return {};
  std::vector<sim::Complex> spectrum_a(static_cast<std::size_t>(fft.bins())), spectrum_b(spectrum_a.size()),
      work(static_cast<std::size_t>(fft.work_length()));
  fft.forward(a, spectrum_a, work);
  fft.forward(b, spectrum_b, work);
  for (std::size_t k = 0; k < spectrum_a.size(); ++k) spectrum_a[k] *= std::conj(spectrum_b[k]);
  fft.inverse(spectrum_a, a, work);

  std::vector<double> correlation(delays, 0.0);
  for (std::size_t d = 0; d < delays; ++d) {
    const double total = sum[d + n] - sum[d];
    const double variance = squares[d + n] - squares[d] - total * total / static_cast<double>(n);
    const double scale = variance * energy;
    if (variance > 1e-12 * squares.back() && scale > 0.0) correlation[d] = a[d] / std::sqrt(scale);
  }
  double largest = 0.0;
  for (const double value : correlation) largest = std::max(largest, std::abs(value));
  std::size_t best = 0;
  while (best + 1 < delays && std::abs(correlation[best]) < largest - 1e-6) ++best;
  while (best + 1 < delays && std::abs(correlation[best + 1]) > std::abs(correlation[best])) ++best;
  double between = 0.0;
  if (best > 0 && best + 1 < delays) {
    const double before = std::abs(correlation[best - 1]), after = std::abs(correlation[best + 1]);
    const double curvature = before - 2.0 * std::abs(correlation[best]) + after;
    if (curvature < 0.0) between = std::clamp(0.5 * (before - after) / curvature, -0.5, 0.5);
  }
  return {static_cast<double>(best) - static_cast<double>(over) + between, correlation[best], a[best] / energy};
}

}  // namespace decid::dataset
