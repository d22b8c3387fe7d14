// Information in the power of noise-driven sway: see noise_power.hpp.
#include "posterior/planning/detail/noise_power.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "base/math/cholesky.hpp"
#include "posterior/density/elementary.hpp"

namespace decid::posterior {
namespace {

constexpr double derivative_step = 1e-4;  // of a fraction, for derivatives

/// Returns the response of the sway to the velocity that passes the dead band, with the gain of the tilt estimate and
/// up to a constant factor: see sim::closed_loop.
sim::Complex response_to_noise(const sim::Protocol& protocol, const sim::Parameters& parameters, double frequency_hz) {
  using enum sim::Coefficient;
  const sim::Family& family = protocol.family();
  const sim::Body& body = protocol.experiment.body;
  const sim::Coefficients c = family.coefficients(parameters);
  const sim::Complex s(0.0, 2.0 * sim::pi * frequency_hz);
  const sim::Complex delayed = (c[kp] + s * c[kd]) * turned(-frequency_hz * c[delay]);
  const sim::Complex fed_back = quotient(c[torque] / body.mgh(), s + 1.0 / family.torque_time_s);
  const sim::Complex loop = quotient(delayed, 1.0 - delayed * fed_back);
  const sim::Complex slow_part = quotient(c[slow], s + 1.0 / family.slow_time_s);
  const sim::Complex passive = c[kp_pass] + s * c[kd_pass] - body.mgh();
  return quotient(c[tilt] * loop, body.inertia_kgm2 * s * s + loop * (c[position] + c[gravity] + slow_part) + passive);
}

}  // namespace

KnownNoise::KnownNoise(std::size_t coefficients, double variance, std::span<const double> inverse_factor)
    : harmonics_(coefficients / 2),
      diagonal_(harmonics_),
      keeping_(harmonics_ * harmonics_),
      inverting_(harmonics_ * harmonics_) {
  // S = 1 - covariance / variance
  std::vector<double> s(coefficients * coefficients, 0.0);
  for (std::size_t i = 0; i < coefficients; ++i) {
    const double* row = inverse_factor.data() + triangle(i);
    for (std::size_t a = 0; a <= i; ++a) {
      const double factor = row[a] / variance;
      double* to = s.data() + a * coefficients;
      for (std::size_t b = 0; b <= a; ++b) to[b] -= factor * row[b];
    }
  }
  for (std::size_t a = 0; a < coefficients; ++a) {
    s[a * coefficients + a] += 1.0;
    for (std::size_t b = 0; b < a; ++b) s[b * coefficients + a] = s[a * coefficients + b];
  }
  for (std::size_t k = 0; k < harmonics_; ++k) {
    const double *sine = s.data() + 2 * k * coefficients, *cosine = sine + coefficients;
    diagonal_[k] = sine[2 * k] + cosine[2 * k + 1];
    for (std::size_t l = 0; l < harmonics_; ++l) {
      const double a = sine[2 * l], b = sine[2 * l + 1], c = cosine[2 * l], d = cosine[2 * l + 1];
      keeping_[k * harmonics_ + l] = 0.5 * ((a + d) * (a + d) + (c - b) * (c - b));
      inverting_[k * harmonics_ + l] = 0.5 * ((a - d) * (a - d) + (b + c) * (b + c));
    }
  }
}

std::vector<double> KnownNoise::third_term(std::span<const std::vector<sim::Complex>> changes) const {
  std::vector<double> matrix(triangle(changes.size()), 0.0);
  for (std::size_t i = 0; i < changes.size(); ++i)
    for (std::size_t k = 0; k < harmonics_; ++k) {
      double real = 0.0, imaginary = 0.0;
      for (std::size_t l = 0; l < harmonics_; ++l) {
        const double keeping = keeping_[k * harmonics_ + l], inverting = inverting_[k * harmonics_ + l];
        real += (keeping + inverting) * changes[i][l].real();
        imaginary += (keeping - inverting) * changes[i][l].imag();
      }
      for (std::size_t j = 0; j <= i; ++j)
        matrix[triangle(i) + j] += real * changes[j][k].real() - imaginary * changes[j][k].imag();
    }
  return matrix;
}

double KnownNoise::second_term(const std::vector<sim::Complex>& changes) const {
  double sum = 0.0;
  for (std::size_t k = 0; k < harmonics_; ++k) sum += changes[k].real() * diagonal_[k];
  return sum;
}

std::vector<std::vector<sim::Complex>> relative_changes(const Density& density, const sim::Parameters& participant,
                                                        std::span<const std::size_t> parameters) {
  const auto harmonics = static_cast<std::size_t>(density.noise_size()) / 2;
  const std::optional<std::size_t> nv = density.protocol().family().find_parameter(sim::Coefficient::nv);
  std::vector<std::vector<sim::Complex>> all;
  for (const std::size_t i : parameters) {
    std::vector<sim::Complex> changes(harmonics);
    const double range = density.quantile(i).range;
    if (nv == i) {
      std::ranges::fill(changes, range / participant[i]);
      all.push_back(std::move(changes));
      continue;
    }
    sim::Parameters low = participant, high = participant;
    low[i] -= derivative_step * range;
    high[i] += derivative_step * range;
    for (std::size_t k = 0; k < harmonics; ++k) {
      const auto at = [&](const sim::Parameters& parameters_there) {
        return response_to_noise(density.protocol(), parameters_there, density.noise_hz(static_cast<int>(2 * k)));
      };
      changes[k] = quotient((at(high) - at(low)) / (2.0 * derivative_step), at(participant));
    }
    all.push_back(std::move(changes));
  }
  return all;
}

}  // namespace decid::posterior
