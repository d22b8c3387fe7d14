// Cross-correlation by FFT, normalised by the standard deviation of the measured tilt in each window: see
// tilt_match.hpp.
#include "recording/detail/tilt/tilt_match.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/fft.hpp"

namespace decid::recording {

namespace {

/// The fraction of a constant signal's squares that rounding may leave after its mean is subtracted: 1e-10 of its size,
/// squared.
constexpr double still = 1e-20;

/// The measurement noise of a tilt changes its correlations by less.
constexpr double same_match = 0.01;

}  // namespace

struct TiltMatcher::Spectrum {
  sim::RealFft fft;
  std::vector<sim::Complex> conjugates;
};

TiltMatcher::TiltMatcher(std::vector<double> expected, int overhang)
    : expected_(std::move(expected)), overhang_(static_cast<std::size_t>(overhang)) {
  double mean = 0.0;
  for (const double value : expected_) mean += value / static_cast<double>(expected_.size());
  for (double& value : expected_) {
    size_ += value * value;
    value -= mean;
    energy_ += value * value;
  }
}

TiltMatcher::~TiltMatcher() = default;

/// Returns the spectrum for a length of a power of two that is at least `min_length`.
const TiltMatcher::Spectrum& TiltMatcher::spectrum(std::size_t min_length) const {
  int length = 2;
  while (static_cast<std::size_t>(length) < min_length) length *= 2;
  const std::lock_guard lock(mutex_);
  std::unique_ptr<const Spectrum>& known = spectra_[length];
  if (known == nullptr) {
    auto made = std::make_unique<Spectrum>(Spectrum{sim::RealFft(length), {}});
    made->conjugates.resize(static_cast<std::size_t>(made->fft.bins()));
    std::vector<double> padded = expected_;
    padded.resize(static_cast<std::size_t>(length), 0.0);
    std::vector<sim::Complex> work(static_cast<std::size_t>(made->fft.work_length()));
    made->fft.forward(padded, made->conjugates, work);
    for (sim::Complex& value : made->conjugates) value = std::conj(value);
    known = std::move(made);
  }
  return *known;
}

Match TiltMatcher::match(std::span<const double> measured) const {
  const std::size_t n = expected_.size(), over = overhang_;
  std::vector<double> padded(over, measured.front());
  padded.insert(padded.end(), measured.begin(), measured.end());
  padded.insert(padded.end(), over, measured.back());
  if (n == 0 || padded.size() < n) return {};
  const std::size_t delays = padded.size() - n + 1;

  const auto& [fft, conjugates] = spectrum(padded.size() + n);

  // Means are subtracted first, so that the sums of squares below are differences of similar numbers.
  double mean = 0.0;
  for (const double value : padded) mean += value / static_cast<double>(padded.size());
  std::vector<double> sum(padded.size() + 1, 0.0), squares(padded.size() + 1, 0.0);
  double padded_size = 0.0;
  for (std::size_t k = 0; k < padded.size(); ++k) {
    padded_size += padded[k] * padded[k];
    padded[k] -= mean;
    sum[k + 1] = sum[k] + padded[k];
    squares[k + 1] = squares[k] + padded[k] * padded[k];
  }
  if (energy_ <= still * size_ || squares.back() <= still * padded_size) return {};
  std::vector<double> a = std::move(padded);
  a.resize(static_cast<std::size_t>(fft.length()), 0.0);
  std::vector<sim::Complex> product(conjugates.size()), work(static_cast<std::size_t>(fft.work_length()));
  fft.forward(a, product, work);
  for (std::size_t k = 0; k < product.size(); ++k) product[k] *= conjugates[k];
  fft.inverse(product, a, work);

  std::vector<double> correlation(delays, 0.0);
  for (std::size_t d = 0; d < delays; ++d) {
    const double total = sum[d + n] - sum[d];
    const double variance = squares[d + n] - squares[d] - total * total / static_cast<double>(n);
    const double scale = variance * energy_;
    if (variance > 1e-12 * squares.back() && scale > 0.0) correlation[d] = a[d] / std::sqrt(scale);
  }
  double largest = 0.0, positive = 0.0;
  for (const double value : correlation) {
    largest = std::max(largest, std::abs(value));
    positive = std::max(positive, value);
  }
  const bool has_sign = positive >= largest - same_match;
  const auto size = [&](std::size_t delay) { return has_sign ? correlation[delay] : std::abs(correlation[delay]); };
  const double limit = (has_sign ? positive : largest) - 1e-6;
  std::size_t best = 0;
  while (best + 1 < delays && size(best) < limit) ++best;
  while (best + 1 < delays && size(best + 1) > size(best)) ++best;
  double between = 0.0;
  if (best > 0 && best + 1 < delays) {
    const double before = size(best - 1), after = size(best + 1);
    const double curvature = before - 2.0 * size(best) + after;
    if (curvature < 0.0) between = std::clamp(0.5 * (before - after) / curvature, -0.5, 0.5);
  }
  return {static_cast<double>(best) - static_cast<double>(over) + between, correlation[best], a[best] / energy_};
}

}  // namespace decid::recording
