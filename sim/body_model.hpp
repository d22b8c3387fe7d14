// Models of body and controller on the platform, with the parameters that are identified.
#pragma once

#include <string>

#include "sim/parameters.hpp"

namespace decid::sim {

struct BodyModel {
  std::string name;
  ParameterTable parameters;
};

/// The parameters of the single pendulum, in the order used everywhere.
enum Index : std::size_t { Kp, Kd, Kp_pass, Kd_pass, Nv, Theta, Delay };

/// Returns the single inverted pendulum under the DEC controller (simulate.hpp). Source of its ranges: table 1 of
/// Lippi, Mergner, Maurer, "Deep Learning for Posture Control Nonlinear Model System and Noise Identification". The
/// gains' ranges are round multiples of 838.99 N m/rad; the default body's m g h is 838.98.
const BodyModel& single_pendulum();

}  // namespace decid::sim
