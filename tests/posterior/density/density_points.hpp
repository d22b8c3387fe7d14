// Points of a density, its values there, and the same noise as explicit matrices.
#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numeric>
#include <optional>
#include <vector>

#include "base/math/cholesky.hpp"
#include "base/math/random.hpp"
#include "posterior/density/density.hpp"
#include "posterior/streams.hpp"
#include "sim/streams.hpp"
#include "tests/posterior/density/dense_noise.hpp"

namespace decid::test {

using namespace posterior;

using Values = AlignedVector<double>;

/// Eight chains at different places.
inline Values random_points(const Density& density, std::uint64_t item) {
  Values x(static_cast<std::size_t>(density.size()) * lanes);
  Random(3, posterior::streams::chains, item).fill_normal(x);
  for (double& value : x) value *= 0.5;
  return x;
}

inline double& at(Values& x, int coordinate, std::size_t chain) {
  return x[static_cast<std::size_t>(coordinate) * lanes + chain];
}

struct Evaluated {
  Values gradient;
  std::vector<double> potential;
};

inline Evaluated evaluate(const Density& density, const Observation& observation, const Values& x,
                          std::optional<double> fixed_noise_deg = {}) {
  Density::Workspace work(density);
  Evaluated result{Values(x.size()), std::vector<double>(lanes)};
  density.evaluate(observation, x, result.gradient, result.potential, work, fixed_noise_deg);
  return result;
}

/// Normal priors of two parameters, one of them in a narrower range, and a range of a third.
inline std::vector<ParameterPrior> parameter_priors() {
  return {{.name = "Kp", .range = ParameterPrior::Range{700.0, 1000.0}, .normal = ParameterPrior::Normal{800.0, 100.0}},
          {.name = "delay", .normal = ParameterPrior::Normal{0.1, 0.03}},
          {.name = "Nv", .range = ParameterPrior::Range{0.1, 0.6}}};
}

struct Modelled {
  Values sway, residual;
};

inline Modelled model(const Density& density, const Observation& observation, const Values& x) {
  Density::Workspace work(density);
  const auto size = static_cast<std::size_t>(density.blocks()) * lanes;
  Modelled result{Values(size), Values(size)};
  density.model(observation, x, result.sway, result.residual, work);
  return result;
}

inline std::vector<double> of_chain(const Values& values, std::size_t l) {
  std::vector<double> result;
  for (std::size_t at = l; at < values.size(); at += lanes) result.push_back(values[at]);
  return result;
}

/// The measurement noise of a chain as spectrum.hpp defines it; slow noise is an Ornstein-Uhlenbeck process.
inline DenseNoise noise_of(const Density& density, const State& state) {
  const double white = density.block_noise_rad(state.sensor_noise_deg), slow = state.slow_noise_deg * sim::rad_per_deg;
  return {static_cast<std::size_t>(density.blocks()),
          density.block_s(),
          density.priors().drift_hz,
          white * white,
          2.0 * slow * slow * state.slow_memory_s / density.block_s(),
          state.slow_memory_s * state.slow_memory_s};
}

/// Returns the number of cosine coefficients up to 2.5 Hz, at most half of all.
inline std::size_t coefficients(const Density& density) {
  const auto up_to = static_cast<std::size_t>(2.0 * density.blocks() * density.block_s() * 2.5) + 1;
  return std::min(up_to, static_cast<std::size_t>(density.blocks() / 2));
}

/// The largest difference of the gradient from a central difference of the potential, over what rounding, the
/// third derivative and the dead band's kinks within a step allow.
inline double worst_gradient(const Density& density, const Observation& observation,
                             std::optional<double> fixed_noise_deg) {
  constexpr double epsilon = std::numeric_limits<double>::epsilon();
  const Values x = random_points(density, 1);
  const Evaluated here = evaluate(density, observation, x, fixed_noise_deg);
  double worst = 0.0;
  for (int i = 0; i < density.size(); ++i) {
    // Steps at which the two errors are alike: the cube root of epsilon.
    const double step = 6e-6;
    Values high = x, low = x;
    for (std::size_t l = 0; l < lanes; ++l) at(high, i, l) += step, at(low, i, l) -= step;
    const Evaluated above = evaluate(density, observation, high, fixed_noise_deg);
    const Evaluated below = evaluate(density, observation, low, fixed_noise_deg);
    for (std::size_t l = 0; l < lanes; ++l) {
      const double difference = (above.potential[l] - below.potential[l]) / (2.0 * step);
      const double gradient = here.gradient[static_cast<std::size_t>(i) * lanes + l];
      const double curvature = std::abs(here.potential[l]);  // second and third derivatives are of the potential's size
      const double allowed = 100.0 * (epsilon * curvature / step + step * step * curvature) + 1e-5 * std::abs(gradient);
      worst = std::max(worst, std::abs(difference - gradient) / allowed);
    }
  }
  return worst;
}

/// The largest difference of the information between two of the coordinates `some` from the product of the model's
/// derivatives, whitened by the explicit noise, over the derivatives' norms. Kinks within a step leave some 1e-4. Reads
/// one of `every` chains.
inline double worst_information(const Density& density, const Observation& observation, const Values& x,
                                const std::vector<int>& some, std::size_t every = 1) {
  Density::Workspace work(density);
  std::vector<double> information(triangle(static_cast<std::size_t>(density.size())) * lanes);
  density.information(observation, x, information, work);
  // The model's offset and line follow its residual, which missing blocks change; the inverse covariance ignores both.
  Observation all = observation;
  all.missing = {};
  const double step = 1e-5;
  std::vector<Values> columns;
  for (const int i : some) {
    Values high = x, low = x;
    for (std::size_t l = 0; l < lanes; ++l) at(high, i, l) += step, at(low, i, l) -= step;
    Values change = model(density, all, high).sway;
    const Values below = model(density, all, low).sway;
    for (std::size_t m = 0; m < change.size(); ++m) change[m] = (change[m] - below[m]) / (2.0 * step);
    columns.push_back(change);
  }
  const std::size_t kept = coefficients(density);
  double worst = 0.0;
  for (std::size_t l = 0; l < lanes; l += every) {
    DenseNoise noise = noise_of(density, density.state(x, static_cast<int>(l)));
    noise.missing = observation.missing.blocks;
    const DenseGaussian gaussian = noise.of_coefficients(kept);
    std::vector<std::vector<double>> whitened;
    for (const Values& column : columns)
      whitened.push_back(gaussian.whitened(noise.transform(kept, of_chain(column, l))));
    const auto product = [&](std::size_t a, std::size_t b) {
      return std::inner_product(whitened[a].begin(), whitened[a].end(), whitened[b].begin(), 0.0);
    };
    for (std::size_t a = 0; a < some.size(); ++a) {
      for (std::size_t b = 0; b < a; ++b) {
        const std::size_t entry = triangle(static_cast<std::size_t>(some[a])) + static_cast<std::size_t>(some[b]);
        const double error =
            std::abs(information[entry * lanes + l] - product(a, b)) / std::sqrt(product(a, a) * product(b, b));
        worst = std::isnan(error) ? std::numeric_limits<double>::infinity() : std::max(worst, error);
      }
    }
  }
  return worst;
}

/// Sets the noise of all chains to that of item `item` of the simulator, in a trial that starts where the density's
/// model does, if its noise has the period of the density's and begins at 1.6 / period: the basis' harmonic 2 stands
/// for 1.5 to 2.5 of them.
inline void set_simulated_noise(const Density& density, double nv, std::uint64_t item, Values& x) {
  const Random normals(5, sim::streams::vestibular_noise, item);
  const double period_s = density.noise_period_s(), radius = std::sqrt(nv * nv + 0.05 * 0.05);
  for (int i = 0; i < density.noise_size() / 2; ++i) {
    const int k = i + 2;
    if (k > period_s) continue;
    // The simulator's deviation is the density at k times 1 / period, the basis' the integral over its band.
    const double from = std::max(1.6, k - 0.5), to = std::min(period_s, k + 0.5);
    const double ratio = std::sqrt(1.0 / k / std::log(to / from)) * radius;
    const std::complex<double> turned = std::complex<double>(normals.normal(2 * static_cast<std::uint64_t>(k) + 1),
                                                             normals.normal(2 * static_cast<std::uint64_t>(k))) *
                                        std::polar(ratio, 2.0 * sim::pi * k * density.first_bin_s() / period_s);
    for (std::size_t l = 0; l < lanes; ++l) at(x, 2 * i, l) = turned.imag(), at(x, 2 * i + 1, l) = turned.real();
  }
}

inline double rms_deg(const std::vector<double>& values) {
  double squares = 0.0;
  for (const double value : values) squares += value * value;
  return std::sqrt(squares / static_cast<double>(values.size())) / sim::rad_per_deg;
}

}  // namespace decid::test
