// A trial of the double pendulum: see double_pendulum.hpp for the equations.
#include "sim/double_pendulum.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/math/math_lanes.hpp"
#include "sim/detail/controller.hpp"

namespace decid::sim {
namespace {

// One DEC module with its delay. Body and support are the servo's; the passive part acts on the joint, whose angle may
// differ from theirs.
class Module {
 public:
  explicit Module(const Parameters& parameters) : p_(parameters), delay_line_(parameters[Delay]) {}

  struct Angle {
    double angle, rate;
  };
  /// Returns the joint's torque on the part above it, from the state at the start of a step; integrates the tilt
  /// estimate over the step.
  double torque(int step, Angle body, Angle support, Angle joint, double noise_rate) {
    const double estimate_rate = apply_dead_band(support.rate + noise_rate, p_[Theta]);
    const double angle = 2.0 * body.angle + (tilt_estimate_ - support.angle);
    const double rate = 2.0 * body.rate + (estimate_rate - support.rate);
    tilt_estimate_ = tilt_estimate_ + integration_step_s * estimate_rate;
    const double active = delay_line_.pass(step, p_[Kp] * angle + p_[Kd] * rate);
    return -(active + (p_[Kp_pass] * joint.angle + p_[Kd_pass] * joint.rate));
  }

 private:
  Parameters p_;
  DelayLine delay_line_;
  double tilt_estimate_ = 0.0;
};

}  // namespace

DoubleBody::DoubleBody(const Segments& s)
    : leg_inertia_(s.leg_mass_kg * (s.leg_com_m * s.leg_com_m) + s.trunk_mass_kg * (s.leg_length_m * s.leg_length_m) +
                   s.leg_inertia_kgm2),
      trunk_inertia_(s.trunk_mass_kg * (s.trunk_com_m * s.trunk_com_m) + s.trunk_inertia_kgm2),
      coupling_(s.trunk_mass_kg * s.leg_length_m * s.trunk_com_m),
      leg_gravity_(gravity * (s.leg_mass_kg * s.leg_com_m + s.trunk_mass_kg * s.leg_length_m)),
      trunk_gravity_(s.trunk_mgh()),
      leg_weight_(leg_gravity_ / (leg_gravity_ + trunk_gravity_)),
      trunk_weight_(trunk_gravity_ / (leg_gravity_ + trunk_gravity_)) {}

DoubleBody::Accelerations DoubleBody::accelerations(const DoubleState& state, double ankle_torque,
                                                    double hip_torque) const {
  const double sin_leg = sin_small_lanes(state.leg_rad), cos_leg = cos_small_lanes(state.leg_rad);
  const double sin_trunk = sin_small_lanes(state.trunk_rad), cos_trunk = cos_small_lanes(state.trunk_rad);
  const double sin_between = sin_leg * cos_trunk - cos_leg * sin_trunk;
  const double cos_between = cos_leg * cos_trunk + sin_leg * sin_trunk;
  const double b = coupling_ * cos_between, centrifugal = coupling_ * sin_between;
  const double r1 =
      ankle_torque - hip_torque - centrifugal * (state.trunk_rate * state.trunk_rate) + leg_gravity_ * sin_leg;
  const double r2 = hip_torque + centrifugal * (state.leg_rate * state.leg_rate) + trunk_gravity_ * sin_trunk;
  const double determinant = leg_inertia_ * trunk_inertia_ - b * b;
  return {.leg = (trunk_inertia_ * r1 - b * r2) / determinant, .trunk = (leg_inertia_ * r2 - b * r1) / determinant};
}

void DoubleBody::step(DoubleState& state, double ankle_torque, double hip_torque, double dt_s) const {
  const Accelerations a = accelerations(state, ankle_torque, hip_torque);
  state.leg_rate = state.leg_rate + dt_s * a.leg;
  state.trunk_rate = state.trunk_rate + dt_s * a.trunk;
  state.leg_rad = state.leg_rad + dt_s * state.leg_rate;
  state.trunk_rad = state.trunk_rad + dt_s * state.trunk_rate;
}

DoubleParameters default_double_parameters(const Segments& segments) {
  const auto scaled = [](double mgh, Parameters parts) {
    for (const Index gain : {Kp, Kd, Kp_pass, Kd_pass}) parts[gain] *= mgh;
    return parts;
  };
  return {.ankle = scaled(make_body(segments).mgh(), {0.9, 0.275, 0.15, 0.15, 0.5, 0.0026, 0.16}),
          .hip = scaled(segments.trunk_mgh(), {0.8, 0.175, 0.5, 0.15, 0.0, 0.0026, 0.07})};
}

DoubleSimulator::DoubleSimulator(Protocol protocol)
    : protocol_(checked(std::move(protocol))),
      segments_(make_segments(make_participant(protocol_.experiment.body))),
      stimulus_(make_stimulus(protocol_.experiment)),
      samples_(protocol_.samples()),
      whole_(protocol_.with_time_before()),
      whole_stimulus_(make_stimulus(whole_.experiment)),
      noise_maker_(whole_) {}

Outcome DoubleSimulator::run(const DoubleParameters& parameters, const Random& noise, const DoubleSway& sway) const {
  check_parameters(parameters.ankle, single_pendulum().parameters, "ankle ");
  check_parameters(parameters.hip, single_pendulum().parameters, "hip ");
  const auto samples = static_cast<std::size_t>(samples_);
  for (const std::span<double>& out : {sway.com_rad, sway.leg_rad, sway.trunk_rad}) {
    if (out.size() == samples) continue;
    throw Error(Code::size_mismatch, "simulation", "an output has space for " + std::to_string(out.size()) + " samples",
                "give space for " + std::to_string(samples));
  }
  const double ankle_nv = parameters.ankle[Nv], hip_nv = parameters.hip[Nv];
  const auto all = static_cast<std::size_t>(whole_.samples()), standing = all - samples;
  std::vector<double> noise_rate(all + 1, 0.0);  // for Nv = 1
  if (ankle_nv > 0.0 || hip_nv > 0.0) noise_maker_.velocity(1.0, noise, noise_rate);

  const DoubleBody body(segments_);
  Module ankle(parameters.ankle), hip(parameters.hip);
  DoubleState state;
  double max_sway = 0.0;
  const int steps_per_sample = protocol_.experiment.steps_per_sample();
  const int standing_steps = static_cast<int>(standing) * steps_per_sample;
  int step = 0;
  for (std::size_t sample = 0; sample < all; ++sample) {
    if (sample >= standing) {
      sway.com_rad[sample - standing] = body.centre_of_mass(state.leg_rad, state.trunk_rad);
      sway.leg_rad[sample - standing] = state.leg_rad;
      sway.trunk_rad[sample - standing] = state.trunk_rad;
    }
    const double noise_slope = (noise_rate[sample + 1] - noise_rate[sample]) / steps_per_sample;
    for (int i = 0; i < steps_per_sample; ++i, ++step) {
      const double noise_now = noise_rate[sample] + i * noise_slope;
      const Module::Angle platform{whole_stimulus_.tilt_at(step), whole_stimulus_.rate_at(step)};
      const Module::Angle com{body.centre_of_mass(state.leg_rad, state.trunk_rad),
                              body.centre_of_mass(state.leg_rate, state.trunk_rate)};
      const Module::Angle leg{state.leg_rad, state.leg_rate}, trunk{state.trunk_rad, state.trunk_rate};
      const auto between = [](Module::Angle above, Module::Angle below) {
        return Module::Angle{above.angle - below.angle, above.rate - below.rate};
      };
      const double ankle_torque = ankle.torque(step, com, platform, between(leg, platform), ankle_nv * noise_now);
      const double hip_torque = hip.torque(step, trunk, leg, between(trunk, leg), hip_nv * noise_now);
      body.step(state, ankle_torque, hip_torque, integration_step_s);

      const double magnitude = std::abs(body.centre_of_mass(state.leg_rad, state.trunk_rad));
      const bool stands = magnitude <= sway_limit_rad && std::abs(state.leg_rad) <= segment_limit_rad &&
                          std::abs(state.trunk_rad) <= segment_limit_rad;  // false for NaN
      max_sway = std::max(max_sway, magnitude);
      if (!stands) {
        return {.valid = false,
                .max_sway_rad = std::isnan(magnitude) ? std::numeric_limits<double>::infinity() : max_sway,
                .end_s = static_cast<double>(std::max(0, step + 1 - standing_steps)) / steps_per_second};
      }
    }
  }
  return {.valid = true, .max_sway_rad = max_sway, .end_s = protocol_.duration_s()};
}

}  // namespace decid::sim
