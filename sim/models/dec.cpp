// `dec`: the DEC controller of Lippi, Mergner, Maurer, "Deep Learning for Posture Control Nonlinear Model System and
// Noise Identification"; ranges from its table 1. The gains' ranges are round multiples of 838.99 N m/rad; the default
// body's m g h is 838.98.
#include "sim/body_model.hpp"
#include "sim/simulate.hpp"

namespace decid::sim {

const BodyModel& single_pendulum() {
  using enum Coefficient;
  static const BodyModel model{"dec",
                               ParameterTable({
                                   {"Kp", "kp", "Active stiffness", "N m/rad", 503.3943, 1258.4857, true},
                                   {"Kd", "kd", "Active damping", "N m s/rad", 125.8486, 377.5457, true},
                                   {"Kp_pass", "kp-pass", "Passive stiffness", "N m/rad", 62.9243, 377.5457, true},
                                   {"Kd_pass", "kd-pass", "Passive damping", "N m s/rad", 62.9243, 188.7729, true},
                                   {"Nv", "nv", "Sensory noise", "1", 0.0, 1.0, false},
                                   {"theta", "theta", "Tilt-speed threshold", "rad/s", 0.0, 0.0052, false},
                                   {"delay", "delay", "Reaction delay", "s", 0.0, 0.24, false, 0.0, longest_delay_s},
                               }),
                               "DEC controller of the paper",
                               [] {
                                 Family family;
                                 family.constant[position] = family.constant[tilt] = family.constant[gravity] = 1.0;
                                 family.terms = {{Kp, kp}, {Kd, kd},       {Kp_pass, kp_pass}, {Kd_pass, kd_pass},
                                                 {Nv, nv}, {Theta, theta}, {Delay, delay}};
                                 return family;
                               }(),
                               "Lippi, Mergner, Maurer, Deep Learning for Posture Control Nonlinear Model System and "
                               "Noise Identification; ranges: table 1"};
  return model;
}

}  // namespace decid::sim
