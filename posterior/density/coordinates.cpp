// Converts between coordinates, which are standard normal under the priors, and the quantities of a state: parameters,
// noises, start and gain. Also computes the derivatives for gradients.
#include <algorithm>
#include <cmath>

#include "base/math/math.hpp"
#include "base/math/random.hpp"
#include "posterior/density/density.hpp"
#include "posterior/sampling/detail/chains.hpp"

namespace decid::posterior {
namespace {

constexpr double nv_scale = 0.05;           // kappa: below it the noise's coefficients are non-centred
constexpr double model_error_deg = 0.0005;  // of a block's mean (the test compares with the simulator)

// The range of the slow noise's memory: its corner frequency is 0.4 Hz to 0.005 Hz.
constexpr double shortest_memory_s = 0.4, longest_memory_s = 30.0;
constexpr double min_slow_ratio = 1e-2;  // relative to the prior's median: far below any observed value
const double log_memory_range = decid::log(longest_memory_s / shortest_memory_s);

}  // namespace

double Density::block_noise_rad(double sensor_noise_deg) const {
  const double of_sensor = sensor_noise_deg / std::sqrt(static_cast<double>(block_samples_));
  return std::sqrt(of_sensor * of_sensor + model_error_deg * model_error_deg) * sim::rad_per_deg;
}

double Density::noise_radius(const sim::Parameters& parameters) const {
  const double nv = family().coefficients(parameters)[sim::Coefficient::nv];
  return std::sqrt(nv * nv + nv_scale * nv_scale);
}

State Density::state(std::span<const double> x, int chain) const {
  const auto at = [&](int quantity) {
    return x[(static_cast<std::size_t>(noise_.size()) + place(quantity)) * lanes + static_cast<std::size_t>(chain)];
  };
  State state;
  state.parameters = sim::Parameters(quantiles_.size());
  for (std::size_t i = 0; i < quantiles_.size(); ++i)
    state.parameters[i] = quantiles_[i].value(at(static_cast<int>(i)));
  state.sensor_noise_deg =
      priors_.sensor_noise_deg * decid::exp(decid::log(priors_.sensor_noise_factor) * at(sensor_noise));
  state.start_s = priors_.start_s * (2.0 * normal_distribution(at(start)) - 1.0);
  state.gain = decid::exp(priors_.gain * at(gain));
  state.slow_noise_deg =
      state.sensor_noise_deg * priors_.slow_ratio * decid::exp(decid::log(priors_.slow_ratio_factor) * at(slow_noise));
  state.slow_memory_s = shortest_memory_s * decid::exp(log_memory_range * normal_distribution(at(slow_memory)));
  return state;
}

void Density::set(const State& state, std::span<double> x, int chain) const {
  const auto at = [&](int quantity) -> double& {
    return x[(static_cast<std::size_t>(noise_.size()) + place(quantity)) * lanes + static_cast<std::size_t>(chain)];
  };
  for (std::size_t i = 0; i < quantiles_.size(); ++i)
    at(static_cast<int>(i)) = quantiles_[i].coordinate(state.parameters[i]);
  set_noise(state.sensor_noise_deg, state.slow_noise_deg, x, chain);
  for (const int quantity : {start, gain, slow_memory}) at(quantity) = prior_coordinate(quantity, state);
}

double Density::prior_coordinate(int quantity, const State& state) const {
  const auto probit = [](double probability) { return inverse_normal(std::clamp(probability, 0.01, 0.99)); };
  switch (quantity) {
    case sensor_noise:
      return decid::log(state.sensor_noise_deg / priors_.sensor_noise_deg) / decid::log(priors_.sensor_noise_factor);
    case start:
      return priors_.start_s > 0.0 ? probit(0.5 * (1.0 + state.start_s / priors_.start_s)) : 0.0;
    case gain:
      return priors_.gain > 0.0 ? decid::log(state.gain) / priors_.gain : 0.0;
    case slow_noise:
      return decid::log(std::max(state.slow_noise_deg / state.sensor_noise_deg, min_slow_ratio * priors_.slow_ratio) /
                        priors_.slow_ratio) /
             decid::log(priors_.slow_ratio_factor);
    case slow_memory:
      return probit(decid::log(state.slow_memory_s / shortest_memory_s) / log_memory_range);
    default:
      return quantiles_[static_cast<std::size_t>(quantity)].coordinate(
          state.parameters[static_cast<std::size_t>(quantity)]);
  }
}

void Density::set_noise(double sensor_noise_deg, double slow_noise_deg, std::span<double> x, int chain) const {
  const auto at = [&](int quantity) -> double& {
    return x[(static_cast<std::size_t>(noise_.size()) + place(quantity)) * lanes + static_cast<std::size_t>(chain)];
  };
  State levels;
  levels.sensor_noise_deg = sensor_noise_deg;
  levels.slow_noise_deg = slow_noise_deg;
  for (const int quantity : {sensor_noise, slow_noise}) at(quantity) = prior_coordinate(quantity, levels);
}

Density::Chains Density::chains(std::span<const double> x, std::optional<double> fixed_noise_deg) const {
  Chains c;
  const double padded_s = padded_blocks_ * bin_steps_ * sim::integration_step_s;
  for (std::size_t l = 0; l < lanes; ++l) {
    const auto coordinate = [&](int quantity) {
      return x[(static_cast<std::size_t>(noise_.size()) + place(quantity)) * lanes + l];
    };
    sim::Parameters parameters(quantiles_.size());
    for (std::size_t i = 0; i < quantiles_.size(); ++i) {
      const double at = coordinate(static_cast<int>(i));
      c.value[i][l] = parameters[i] = quantiles_[i].value(at);
      c.d_coordinate[i][l] = quantiles_[i].slope(at);
    }
    const sim::Coefficients coefficients = family().coefficients(parameters);
    for (std::size_t i = 0; i < sim::Coefficients::count; ++i)
      c.coefficients[i][l] = coefficients[static_cast<sim::Coefficient>(i)];
    c.value[place(start)][l] = priors_.start_s * (2.0 * normal_distribution(coordinate(start)) - 1.0);
    c.d_coordinate[place(start)][l] = 2.0 * priors_.start_s * normal_density(coordinate(start));
    c.value[place(gain)][l] = decid::exp(priors_.gain * coordinate(gain));
    c.d_coordinate[place(gain)][l] = priors_.gain * c.value[place(gain)][l];
    set_noise(c, l, coordinate(sensor_noise), coordinate(slow_noise), coordinate(slow_memory), fixed_noise_deg);
    const double nv = c[sim::Coefficient::nv][l], radius = std::sqrt(nv * nv + nv_scale * nv_scale);
    c.radius[l] = radius;
    c.noise_gain[l] = nv / radius;
    c.d_nv[l] = nv_scale * nv_scale / (radius * radius * radius);
    const double angle = 2.0 * sim::pi / padded_s;
    const double delay_s = c[sim::Coefficient::delay][l], start_s = c.value[place(start)][l];
    c.delay_first[0][l] = decid::exp(-damping_ * delay_s);
    c.delay_first[1][l] = 0.0;
    c.delay_turn[0][l] = cos_small(angle * delay_s);
    c.delay_turn[1][l] = -sin_small(angle * delay_s);
    c.start_first[0][l] = decid::exp(damping_ * start_s);
    c.start_first[1][l] = 0.0;
    c.start_turn[0][l] = cos_small(angle * start_s);
    c.start_turn[1][l] = sin_small(angle * start_s);
  }
  return c;
}

void Density::set_noise(Chains& c, std::size_t l, double white, double slow, double memory,
                        std::optional<double> fixed_noise_deg) const {
  const double spread = decid::log(priors_.sensor_noise_factor), slow_spread = decid::log(priors_.slow_ratio_factor);
  const double noise_deg = fixed_noise_deg.value_or(priors_.sensor_noise_deg * decid::exp(spread * white));
  const double noise_rad = block_noise_rad(noise_deg);
  const double of_model = model_error_deg * sim::rad_per_deg / noise_rad;
  c.value[place(sensor_noise)][l] = noise_deg;
  c.levels.white[l] = noise_rad * noise_rad;
  const double slow_rad = noise_deg * priors_.slow_ratio * decid::exp(slow_spread * slow) * sim::rad_per_deg;
  const double memory_s = shortest_memory_s * decid::exp(log_memory_range * normal_distribution(memory));
  c.value[place(slow_noise)][l] = slow_rad / sim::rad_per_deg;
  c.value[place(slow_memory)][l] = memory_s;
  // The power of an Ornstein-Uhlenbeck process in the cosine transform of its blocks, below its corner.
  c.levels.slow[l] = fixed_noise_deg ? 0.0 : slow_rad * slow_rad * 2.0 * memory_s / block_s();
  c.levels.memory[l] = memory_s * memory_s;
  // Derivatives of the logarithms: of white by its coordinate, of slow by both of its own, of memory by its own.
  c.d_white[l] = fixed_noise_deg ? 0.0 : 2.0 * spread * (1.0 - of_model * of_model);
  c.d_slow_white[l] = fixed_noise_deg ? 0.0 : 2.0 * spread;
  c.d_slow[l] = fixed_noise_deg ? 0.0 : 2.0 * slow_spread;
  c.d_memory[l] = fixed_noise_deg ? 0.0 : log_memory_range * normal_density(memory);
}

}  // namespace decid::posterior
