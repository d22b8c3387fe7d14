// Models of body and controller: see body_model.hpp.
#include "sim/body_model.hpp"

#include "sim/simulate.hpp"

namespace decid::sim {

const BodyModel& single_pendulum() {
  static const BodyModel model{"single pendulum",
                               ParameterTable({
                                   {"Kp", "kp", "Active stiffness", "N m/rad", 503.3943, 1258.4857, true},
                                   {"Kd", "kd", "Active damping", "N m s/rad", 125.8486, 377.5457, true},
                                   {"Kp_pass", "kp-pass", "Passive stiffness", "N m/rad", 62.9243, 377.5457, true},
                                   {"Kd_pass", "kd-pass", "Passive damping", "N m s/rad", 62.9243, 188.7729, true},
                                   {"Nv", "nv", "Sensory noise", "1", 0.0, 1.0, false},
                                   {"theta", "theta", "Tilt-speed threshold", "rad/s", 0.0, 0.0052, false},
                                   {"delay", "delay", "Reaction delay", "s", 0.0, 0.24, false, 0.0, longest_delay_s},
                               })};
  return model;
}

}  // namespace decid::sim
