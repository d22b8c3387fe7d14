// A trial by the equations of the family of controllers, written straight down.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/math/random.hpp"
#include "sim/family.hpp"
#include "sim/simulate.hpp"

namespace decid::test {

/// Returns the sway of every step by the equations of sim/family.hpp on the 1 ms grid, up to and including the first
/// out of bounds.
inline std::vector<double> straightforward(const sim::Protocol& protocol, const sim::Parameters& parameters,
                                           const Random& noise) {
  using namespace sim;
  using enum Coefficient;
  const Family& family = protocol.family();
  const Coefficients c = family.coefficients(parameters);
  const Body& body = protocol.experiment.body;
  const Stimulus stimulus = make_stimulus(protocol.experiment);
  const int per_sample = protocol.experiment.steps_per_sample();
  std::vector<double> noise_rate(static_cast<std::size_t>(protocol.samples()) + 1);
  VestibularNoiseMaker(protocol).velocity(c[nv], noise, noise_rate);
  const double dt = 0.001, band = protocol.gravity_dead_band_deg * rad_per_deg;
  double a = 0.0, a_rate = 0.0, e = 0.0, q = 0.0, r = 0.0, delayed = 0.0;
  std::vector<double> u, sway{0.0};
  for (int k = 0; k < protocol.experiment.steps(); ++k) {
    const auto sample = static_cast<std::size_t>(k / per_sample);
    const double part = static_cast<double>(k % per_sample) / per_sample;
    const double f = stimulus.tilt_at(k), f_rate = stimulus.rate_at(k);
    const double heard = f_rate + (1.0 - part) * noise_rate[sample] + part * noise_rate[sample + 1];
    const double e_rate = c[tilt] * (heard - std::clamp(heard, -c[theta], c[theta]));
    const double q_rate = c[slow] * a - q / family.slow_time_s;
    const double r_rate = c[torque] * delayed / body.mgh() - r / family.torque_time_s;
    const double felt = a - std::clamp(a, -band, band), felt_rate = std::abs(a) < band ? 0.0 : a_rate;
    u.push_back(c[kp] * (c[position] * (a - f) + e + c[gravity] * felt + q + r) +
                c[kd] * (c[position] * (a_rate - f_rate) + e_rate + c[gravity] * felt_rate + q_rate + r_rate));
    e += dt * e_rate;
    q += dt * q_rate;
    r += dt * r_rate;
    const double place = k - std::round(c[delay] * 1e6) / 1e3;
    const auto before = static_cast<std::size_t>(std::max(place, 0.0));
    const double between = place - static_cast<double>(before);
    delayed = place < 0.0 ? 0.0 : between == 0.0 ? u[before] : (1.0 - between) * u[before] + between * u[before + 1];
    const double torque = body.mgh() * std::sin(a) - delayed - c[kp_pass] * (a - f) - c[kd_pass] * (a_rate - f_rate);
    a_rate += dt * torque / body.inertia_kgm2;
    a += dt * a_rate;
    sway.push_back(a);
    if (std::abs(a) > 5.0 * rad_per_deg) break;
  }
  return sway;
}

}  // namespace decid::test
