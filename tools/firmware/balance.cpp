// The trial of a controller's self-test: see balance.hpp.
#include "tools/firmware/balance.hpp"

#include <algorithm>
#include <cmath>

#include "sim/lanes.hpp"

namespace decid::tools {
namespace {

double clamped(double x, double low, double high) {
  const double below = x < high ? x : high;
  return below > low ? below : low;
}

}  // namespace

sim::Stimulus stimulus_at(const sim::Stimulus& stimulus, int steps_per_second) {
  constexpr int intervals_per_second = 100;
  sim::Stimulus made;
  made.interval_steps = std::max(1, steps_per_second / intervals_per_second);
  const double interval_s = static_cast<double>(made.interval_steps) / steps_per_second;
  const double point_s = stimulus.interval_steps * sim::integration_step_s;
  const double end_s = static_cast<double>(stimulus.rate_rad_s.size()) * point_s;
  const auto tilt_at = [&](double t_s) {
    const auto point = std::min(static_cast<std::size_t>(t_s / point_s), stimulus.rate_rad_s.size() - 1);
    return stimulus.tilt_rad[point] + stimulus.rate_rad_s[point] * (t_s - static_cast<double>(point) * point_s);
  };
  const int intervals = static_cast<int>(end_s / interval_s + 1e-6);
  for (int i = 0; i < intervals; ++i) {
    made.tilt_rad.push_back(tilt_at(i * interval_s));
    made.rate_rad_s.push_back((tilt_at((i + 1) * interval_s) - made.tilt_rad.back()) / interval_s);
  }
  return made;
}

std::array<double, 3> sine_coefficients_at(const sim::Body& body, int steps_per_second) {
  std::array<double, 3> all = sim::sine_coefficients_for(body);
  for (double& value : all) value *= 1.0 / steps_per_second / sim::integration_step_s;
  return all;
}

Balanced balance(const sim::Family& family, const sim::Coefficients& of, const sim::Body& body,
                 const sim::Stimulus& stimulus, int steps_per_second) {
  using enum sim::Coefficient;
  const double step_s = 1.0 / steps_per_second, c = step_s / body.inertia_kgm2;
  const double active_stiffness = c * of[kp], active_damping = c * of[kd];
  const double passive = c * of[kp_pass], damping = c * of[kd_pass], lean = c * (body.mgh() - of[kp_pass]);
  const double reach = of[position] + of[gravity], tilt_over_servo = of[tilt] - of[position];
  const double threshold = of[tilt] * of[theta], torque_gain = of[torque] / (c * body.mgh());
  const double slow_leak = 1.0 / family.slow_time_s, torque_leak = 1.0 / family.torque_time_s;
  const std::array<double, 3> sine = sine_coefficients_at(body, steps_per_second);
  double delay_steps = of[delay] * steps_per_second;
  if (const double nearest = std::floor(delay_steps + 0.5); std::abs(delay_steps - nearest) < 1e-9)
    delay_steps = nearest;
  const auto whole = static_cast<std::size_t>(delay_steps);
  const double fraction = delay_steps - static_cast<double>(whole);
  const std::size_t first_step = whole + (fraction > 0.0 ? 1 : 0);

  double sway = 0.0, rate = 0.0, error = 0.0, slow_angle = 0.0, torque_angle = 0.0, active = 0.0, before = 0.0;
  std::vector<double> commands;
  double peak = 0.0;
  Balanced found;
  for (std::size_t interval = 0; interval < stimulus.rate_rad_s.size(); ++interval) {
    if (!(std::abs(sway) <= sim::sway_limit_rad)) break;
    found.sway.push_back(sway);
    const double support = stimulus.rate_rad_s[interval], drive_slope = passive * (support * step_s);
    const double q = (0.0 - clamped(of[tilt] * support, -threshold, threshold)) + tilt_over_servo * support;
    double drive = std::fma(passive, stimulus.tilt_rad[interval], damping * support);
    for (int i = 0; i < stimulus.interval_steps; ++i) {
      const double slow_rate = std::fma(of[slow], sway, -(slow_leak * slow_angle));
      const double torque_rate = std::fma(torque_gain, active, -(torque_leak * torque_angle));
      const std::size_t step = commands.size();
      commands.push_back(std::fma(active_stiffness, std::fma(reach, sway, error + (slow_angle + torque_angle)),
                                  active_damping * std::fma(reach, rate, q + (slow_rate + torque_rate))));
      slow_angle = std::fma(slow_rate, step_s, slow_angle);
      torque_angle = std::fma(torque_rate, step_s, torque_angle);
      error = std::fma(q, step_s, error);
      const double newer = step >= whole ? commands[step - whole] : 0.0;
      active = step < first_step ? 0.0 : std::fma(fraction, before - newer, newer);
      before = newer;
      peak = std::max(peak, std::abs(active));
      const double z = sway * sway, polynomial = std::fma(std::fma(sine[2], z, sine[1]), z, sine[0]);
      const double next = std::fma(lean, sway, std::fma(1.0 - damping, rate, drive - active));
      drive = drive + drive_slope;
      rate = std::fma(sway * z, polynomial, next);
      sway = std::fma(rate, step_s, sway);
    }
  }
  found.peak_active_torque_nm = peak / c;
  return found;
}

}  // namespace decid::tools
