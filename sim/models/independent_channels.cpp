// `ic`: independent channels, Peterka, J Neurophysiol 88, 2002, and 118, 2018: v = a - W f + (1 - W) nu, with the
// weight W of proprioception and 1 - W of the vestibular sense, without a dead band. In the family this is a tilt
// estimate of gain 1 - W in a servo of gain 1. Positive torque feedback brings the body upright slowly. Values over m g
// h for a tilt of 1 degree: Kp 1.5, Kd .4, W .6, delay .19 s; W falls as the tilt grows.
#include "sim/body_model.hpp"
#include "sim/simulate.hpp"

namespace decid::sim {

const BodyModel& independent_channels() {
  using enum Coefficient;
  const double mgh = Body{}.mgh();  // ranges are those of the default body
  static const BodyModel model{"ic",
                               ParameterTable({
                                   {"Kp", "kp", "Active stiffness", "N m/rad", 1.05 * mgh, 2.5 * mgh, true},
                                   {"Kd", "kd", "Active damping", "N m s/rad", 0.1 * mgh, mgh, true},
                                   {"W", "weight", "Weight of proprioception", "1", 0.01, 1.0, false, 0.0, 1.0},
                                   {"Kt", "torque-gain", "Torque feedback", "1/s", 0.0, 0.05, false},
                                   {"Nv", "nv", "Sensory noise", "1", 0.0, 1.0, false},
                                   {"delay", "delay", "Reaction delay", "s", 0.1, 0.3, false, 0.0, longest_delay_s},
                               }),
                               "Independent channels of proprioception and vestibular sense",
                               [] {
                                 Family family;
                                 family.constant[position] = family.constant[tilt] = 1.0;
                                 family.terms = {{0, kp}, {1, kd}, {2, tilt, -1.0}, {3, torque}, {4, nv}, {5, delay}};
                                 family.torque_time_s = 20.0;
                                 return family;
                               }(),
                               "Peterka, J Neurophysiol 88, 2002, and 118, 2018"};
  return model;
}

}  // namespace decid::sim
