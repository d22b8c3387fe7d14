// A plain trial: one pendulum, one step after the other, in double arithmetic. It is the baseline for the lanes of
// sim/simulate.hpp; its sway differs from theirs only by rounding.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "sim/simulate.hpp"

namespace decid::bench {

/// noise_rate: rad/s at each sample and the end. Returns the samples' largest sway; stops beyond the bound.
inline double plain_trial(const sim::Simulator& simulator, const sim::Parameters& parameters,
                          const std::vector<double>& noise_rate, std::vector<double>& sway_rad) {
  constexpr double step_s = 0.001;
  const sim::Body& body = simulator.protocol().experiment.body;
  const double mgh = body.mgh(), kp = parameters[sim::Kp], kd = parameters[sim::Kd];
  const double kp_pass = parameters[sim::Kp_pass], kd_pass = parameters[sim::Kd_pass], theta = parameters[sim::Theta];
  const double lag = parameters[sim::Delay] / step_s;
  const auto whole = static_cast<unsigned>(lag);
  const double fraction = lag - whole;
  std::array<double, 1024> ring{};
  double sway = 0.0, rate = 0.0, estimate = 0.0, largest = 0.0;
  const int steps_per_sample = simulator.protocol().experiment.steps_per_sample();
  unsigned step = 0;
  for (std::size_t sample = 0; sample < sway_rad.size(); ++sample) {
    sway_rad[sample] = sway;
    const double slope = (noise_rate[sample + 1] - noise_rate[sample]) / steps_per_sample;
    const double platform_rate = simulator.stimulus().rate_rad_s[sample];
    for (int i = 0; i < steps_per_sample; ++i, ++step) {
      const double platform = simulator.stimulus().tilt_rad[sample] + i * step_s * platform_rate;
      const double heard = platform_rate + noise_rate[sample] + i * slope;
      const double estimate_rate = heard - std::clamp(heard, -theta, theta);
      ring[step % 1024] = kp * (2 * sway + estimate - platform) + kd * (2 * rate + estimate_rate - platform_rate);
      estimate += step_s * estimate_rate;
      double active = 0.0;
      if (step >= lag) {
        active = (1 - fraction) * ring[(step - whole) % 1024] + fraction * ring[(step - whole - 1) % 1024];
      }
      const double passive = kp_pass * (sway - platform) + kd_pass * (rate - platform_rate);
      rate += step_s * ((mgh * std::sin(sway) - active - passive) / body.inertia_kgm2);
      sway += step_s * rate;
      largest = std::max(largest, std::abs(sway));
    }
    if (!(largest <= sim::sway_limit_rad)) break;
  }
  return largest;
}

}  // namespace decid::bench
