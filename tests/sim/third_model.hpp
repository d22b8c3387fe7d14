// A model of body and controller that the library does not have, as a program outside would add it.
#pragma once

#include "sim/simulate.hpp"

namespace decid::test {

/// All coefficients free, a gain that acts on two of them.
inline const sim::BodyModel& third_model() {
  using namespace sim;
  using enum Coefficient;
  static const BodyModel model{.name = "third",
                               .parameters = ParameterTable({
                                   {"Kp", "kp", "Active proportional gain", "N m/rad", 700.0, 1200.0, true},
                                   {"Kd", "kd", "Active derivative gain", "N m s/rad", 200.0, 350.0, true},
                                   {"share", "share", "Share of the servo", "1", 0.6, 1.0, false, 0.0, 1.0},
                                   {"slow", "slow", "Slow feedback", "1/s", 0.0, 0.2, false},
                                   {"torque", "torque", "Torque feedback", "1/s", 0.0, 0.03, false},
                                   {"Nv", "nv", "Vestibular noise gain", "1", 0.0, 1.0, false},
                                   {"theta", "theta", "Threshold", "rad/s", 0.0, 0.005, false},
                                   {"delay", "delay", "Lumped delay", "s", 0.05, 0.2, false, 0.0, longest_delay_s},
                               }),
                               .family = [] {
                                 Family family;
                                 family.constant[tilt] = 0.2;
                                 family.constant[gravity] = 1.3;
                                 family.constant[kp_pass] = 110.0;
                                 family.constant[kd_pass] = 60.0;
                                 family.terms = {
                                     {0, kp},   {1, kd},     {2, position}, {2, tilt, 0.7}, {2, gravity, -0.5},
                                     {3, slow}, {4, torque}, {5, nv},       {6, theta},     {7, delay}};
                                 family.slow_time_s = 12.0;
                                 family.torque_time_s = 17.0;
                                 return family;
                               }()};
  return model;
}

}  // namespace decid::test
