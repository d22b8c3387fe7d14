// Points of a density, its values there, and the same noise as explicit matrices.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "base/math/random.hpp"
#include "posterior/density/density.hpp"
#include "posterior/streams.hpp"
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

}  // namespace decid::test
