// The basis of the vestibular noise: see noise_basis.hpp.
#include "posterior/density/noise_basis.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/error.hpp"
#include "base/math/math.hpp"

namespace decid::posterior {
namespace {

constexpr double period_over_trial = 1.2;

/// Returns the shortest even divisor of `points` that resolves harmonic `last`.
int shortest_transform(int points, int last) {
  for (int length = 2 * last + 2; length < points; ++length) {
    if (length % 2 == 0 && points % length == 0) return length;
  }
  return points;
}

/// Returns the integral of f^-exponent from low to high.
double power(double low, double high, double exponent) {
  if (exponent == 1.0) return decid::log(high / low);
  const double order = 1.0 - exponent;
  return (decid::exp(order * decid::log(high)) - decid::exp(order * decid::log(low))) / order;
}

int points_of(int edges, int trial_edges) {
  return sim::smooth_length(std::max(edges, static_cast<int>(period_over_trial * trial_edges)) + 1);
}

int last_harmonic(const sim::VestibularNoise& noise, double period_s, double highest_hz) {
  return static_cast<int>(std::floor(std::min(noise.high_hz, highest_hz) * period_s + 0.5));
}

/// The size is a compile-time constant, which avoids a call.
void copy_lanes(const double* from, double* to) {
  std::memcpy(to, from, lanes * sizeof(double));
}

}  // namespace

NoiseBasis::NoiseBasis(const sim::Protocol& protocol, int bin_steps, int edges, int trial_edges, double highest_hz)
    : edges_(edges),
      points_(points_of(edges, trial_edges)),
      first_(1),
      period_s_(points_ * bin_steps * sim::integration_step_s),
      fft_(shortest_transform(points_, last_harmonic(protocol.noise.vestibular, period_s_, highest_hz))),
      phases_(points_ / fft_.length()) {
  const sim::VestibularNoise& noise = protocol.noise.vestibular;
  const double high = std::min(noise.high_hz, highest_hz);
  const int last = last_harmonic(noise, period_s_, highest_hz);
  first_ = std::max(1, static_cast<int>(std::floor(noise.low_hz * period_s_ + 0.5)));
  const double scale = noise.scale_deg * sim::rad_per_deg;
  for (int k = first_; k <= last && scale > 0.0; ++k) {
    const double from = k == first_ ? noise.low_hz : std::max(noise.low_hz, (k - 0.5) / period_s_);
    const double to = k == last ? high : std::min(high, (k + 0.5) / period_s_);
    if (!(to > from)) continue;
    const double frequency_hz = k / period_s_;
    stddevs_.push_back(scale * std::sqrt(power(from, to, noise.exponent)) * 2.0 * sim::pi * frequency_hz);
  }
  for (int r = 0; r < phases_; ++r) {
    for (std::size_t i = 0; i < stddevs_.size(); ++i) {
      const auto [sin, cos] = sincos_of_turn(static_cast<long long>(first_ + static_cast<int>(i)) * r, points_);
      turns_.push_back(cos);
      turns_.push_back(sin);
    }
  }
  for (int j = 0; j < points_; ++j) turn_.push_back(sincos_of_turn(j, points_));
}

NoiseBasis::Parts NoiseBasis::parts(double* work) const {
  std::size_t used = 0;
  const auto next = [&](int values) {
    const auto count = static_cast<std::size_t>(values) * lanes;
    used += count;
    return std::span(work + (used - count), count);
  };
  const std::span<double> coefficients = next(size()), spectrum = next(2 * fft_.bins());
  const std::span<double> signal = next(fft_.length()), rest = next(2 * fft_.work_length());
  return {coefficients, spectrum, signal, rest};
}

std::size_t NoiseBasis::work_size() const {
  return static_cast<std::size_t>(size() + 2 * fft_.bins() + fft_.length() + 2 * fft_.work_length()) * lanes;
}

// Harmonic k with coefficients a, b has the velocity sd (b cos - a sin) of 2 pi k t / period, the real part of (b + i
// a) exp(2 pi i k t / period).
void NoiseBasis::synthesize(const double* coefficients, double* velocity, double* work, Isa isa) const {
  const std::size_t harmonics = stddevs_.size(), apart = lanes;
  const auto phases = static_cast<std::size_t>(phases_);
  const auto [scaled, spectrum, signal, rest] = parts(work);
  for (std::size_t i = 0; i < harmonics; ++i) {
    const double factor = 0.5 * fft_.length() * stddevs_[i];
    for (std::size_t l = 0; l < apart; ++l) {
      scaled[2 * i * apart + l] = factor * coefficients[(2 * i + 1) * apart + l];
      scaled[(2 * i + 1) * apart + l] = factor * coefficients[2 * i * apart + l];
    }
  }
  std::ranges::fill(spectrum, 0.0);
  double* const band = spectrum.data() + 2 * static_cast<std::size_t>(first_) * apart;
  for (std::size_t r = 0; r < phases; ++r) {
    kernels(isa).turn(static_cast<int>(harmonics), scaled.data(), turns_.data() + 2 * r * harmonics, band);
    fft_.inverse_lanes(spectrum, signal, rest, isa);
    for (std::size_t m = 0, edge = r; edge < static_cast<std::size_t>(edges_); ++m, edge += phases)
      copy_lanes(signal.data() + m * apart, velocity + edge * apart);
  }
}

void NoiseBasis::gradient(const double* by_velocity, double* by_coefficient, double* work, Isa isa) const {
  const std::size_t harmonics = stddevs_.size(), apart = lanes;
  const auto phases = static_cast<std::size_t>(phases_);
  const auto [sums, spectrum, signal, rest] = parts(work);
  std::ranges::fill(sums, 0.0);
  for (std::size_t r = 0; r < phases; ++r) {
    std::size_t m = 0;
    for (std::size_t edge = r; edge < static_cast<std::size_t>(edges_); ++m, edge += phases)
      copy_lanes(by_velocity + edge * apart, signal.data() + m * apart);
    std::ranges::fill(signal.subspan(m * apart), 0.0);
    fft_.forward_lanes(signal, spectrum, rest, isa);
    // The sum of g exp(-i w t): its real part belongs to b, its imaginary part, -sum g sin, to a.
    kernels(isa).add_conjugate_product(static_cast<int>(harmonics),
                                       spectrum.data() + 2 * static_cast<std::size_t>(first_) * apart,
                                       turns_.data() + 2 * r * harmonics, sums.data());
  }
  for (std::size_t i = 0; i < harmonics; ++i) {
    for (std::size_t l = 0; l < apart; ++l) {
      by_coefficient[2 * i * apart + l] = stddevs_[i] * sums[(2 * i + 1) * apart + l];
      by_coefficient[(2 * i + 1) * apart + l] = stddevs_[i] * sums[2 * i * apart + l];
    }
  }
}

void NoiseBasis::column(int coefficient, std::span<double> velocity) const {
  const auto i = static_cast<std::size_t>(coefficient / 2);
  const auto points = static_cast<std::size_t>(points_), k = static_cast<std::size_t>(first_) + i;
  std::size_t place = 0;
  for (std::size_t edge = 0; edge < static_cast<std::size_t>(edges_); ++edge) {
    velocity[edge] = stddevs_[i] * (coefficient % 2 == 1 ? turn_[place].cos : -turn_[place].sin);
    place = (place + k) % points;
  }
}

}  // namespace decid::posterior
