// `dec2015`: the DEC controller with which the Freiburg laboratory describes people, after its published block diagrams
// and parameter files of 2015. The servo, the tilt estimate and the estimate of gravity have gains of their own, and
// the body's angle feeds back slowly. Values for closed eyes, gains over m g h: Kp 1, Kd .30, passive .15 and .045,
// servo .85, tilt .75, gravity .55, slow .13 /s with 15 s, threshold .33 degrees/s, delay .16 s; the ranges surround
// them. A factor of Kp and Kd that divides the other gains changes nothing, so the laboratory, and a fit here, fix Kp
// at m g h. The laboratory also has a dead band of .07 degrees before the gravity gain, which Protocol can simulate.
#include <limits>

#include "sim/body_model.hpp"
#include "sim/simulate.hpp"

namespace decid::sim {

const BodyModel& dec2015() {
  using enum Coefficient;
  const double mgh = Body{}.mgh();  // ranges are those of the default body
  static const BodyModel model{
      "dec2015",
      ParameterTable({
          {"Kp", "kp", "Active stiffness", "N m/rad", 0.6 * mgh, 1.5 * mgh, true, 0.0,
           std::numeric_limits<double>::infinity(), mgh},
          {"Kd", "kd", "Active damping", "N m s/rad", 0.15 * mgh, 0.5 * mgh, true},
          {"Kp_pass", "kp-pass", "Passive stiffness", "N m/rad", 0.05 * mgh, 0.45 * mgh, true},
          {"Kd_pass", "kd-pass", "Passive damping", "N m s/rad", 0.02 * mgh, 0.225 * mgh, true},
          {"Nv", "nv", "Sensory noise", "1", 0.0, 1.0, false},
          {"theta", "theta", "Tilt-speed threshold", "rad/s", 0.0, 0.0105, false},
          {"delay", "delay", "Reaction delay", "s", 0.05, 0.24, false, 0.0, longest_delay_s},
          {"S", "servo", "Gain of the ankle angle in the servo", "1", 0.6, 1.2, false},
          {"G_f", "tilt-gain", "Gain of the tilt estimate", "1", 0.4, 1.1, false},
          {"G_g", "gravity-gain", "Gain of the gravity estimate", "1", 0.0, 1.0, false},
          {"G_q", "slow-gain", "Slow feedback of the body angle", "1/s", 0.0, 0.26, false},
      }),
      "DEC controller with free gains and slow feedback",
      [] {
        Family family;
        family.terms = {{Kp, kp},  {Kd, kd},       {Kp_pass, kp_pass}, {Kd_pass, kd_pass},
                        {Nv, nv},  {Theta, theta}, {Delay, delay},     {7, position},
                        {8, tilt}, {9, gravity},   {10, slow}};
        family.slow_time_s = 15.0;
        return family;
      }(),
      "Block diagrams and parameter files of the Freiburg laboratory, 2015, eyes closed; the ranges surround its "
      "values"};
  return model;
}

}  // namespace decid::sim
