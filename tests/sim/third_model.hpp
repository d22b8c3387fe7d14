// A model of the family that the library does not have, and all models for tests of the family.
#pragma once

#include <vector>

#include "sim/protocol/protocol.hpp"
#include "sim/simulate.hpp"

namespace decid::test {

/// All coefficients differ from those of `dec`, one parameter acts on three of them, and the order is another one.
inline const sim::BodyModel& third_model() {
  using enum sim::Coefficient;
  static const sim::BodyModel model{
      .name = "third",
      .parameters = sim::ParameterTable({
          {"delay", "delay", "Reaction delay", "s", 0.05, 0.2, false, 0.0, sim::longest_delay_s},
          {"Kp", "kp", "Active stiffness", "N m/rad", 700.0, 1200.0, true},
          {"Kd", "kd", "Active damping", "N m s/rad", 200.0, 350.0, true},
          {"share", "share", "Share of the servo", "1", 0.6, 1.0, false, 0.0, 1.0},
          {"slow", "slow", "Slow feedback", "1/s", 0.0, 0.2, false},
          {"torque", "torque", "Torque feedback", "1/s", 0.0, 0.03, false},
          {"theta", "theta", "Threshold", "rad/s", 0.001, 0.005, false},
          {"Nv", "nv", "Sensory noise", "1", 0.0, 1.0, false},
      }),
      .family = [] {
        sim::Family family;
        family.constant[tilt] = 0.2;
        family.constant[gravity] = 1.3;
        family.constant[kp_pass] = 110.0;
        family.constant[kd_pass] = 60.0;
        family.terms = {{0, delay},         {1, kp},   {2, kd},     {3, position}, {3, tilt, 0.7},
                        {3, gravity, -0.5}, {4, slow}, {5, torque}, {6, theta},    {7, nv}};
        family.slow_time_s = 12.0;
        family.torque_time_s = 17.0;
        return family;
      }()};
  return model;
}

/// Returns all models that can be simulated, the third among them.
inline std::vector<const sim::BodyModel*> all_models() {
  sim::register_body_model(third_model());
  std::vector<const sim::BodyModel*> all = sim::body_models();
  std::erase_if(all, [](const sim::BodyModel* model) { return model->family.terms.empty(); });
  return all;
}

/// Returns the protocol with another controller.
inline sim::Protocol with_model(sim::Protocol protocol, const sim::BodyModel& model) {
  protocol.experiment.body_model = &model;
  return protocol;
}

}  // namespace decid::test
