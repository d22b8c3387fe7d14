// The seven parameters that decid identifies: names, units and ranges, in the one order used everywhere.
// Source: table 1 of Lippi, Mergner, Maurer, "Deep Learning for Posture Control Nonlinear Model System and Noise
// Identification". The gains' ranges are round multiples of 838.99 N m/rad; the default body's m g h is 838.98.
#pragma once

#include <array>
#include <cstddef>
#include <string>

namespace decid::sim {

enum Index : std::size_t { Kp, Kd, Kp_pass, Kd_pass, Nv, Theta, Delay };
inline constexpr std::size_t parameter_count = 7;

/// One set of parameters, in SI units, indexed by Index.
using Parameters = std::array<double, parameter_count>;

struct ParameterInfo {
  const char* name;         ///< as in files: "Kp_pass"
  const char* option;       ///< as on the command line: "kp-pass"
  const char* description;  ///< for people: "Passive stiffness"
  const char* unit;         ///< "1": a plain number
  double low, high;         ///< range of the uniform distribution of the data set
  bool per_mgh;             ///< value / (m g h) has a meaning

  double middle() const { return 0.5 * (low + high); }
  /// For people, to whom a plain number has none.
  const char* shown_unit() const { return unit[0] == '1' ? "" : unit; }
};

inline constexpr std::array<ParameterInfo, parameter_count> parameter_info{{
    {"Kp", "kp", "Active proportional gain", "N m/rad", 503.3943, 1258.4857, true},
    {"Kd", "kd", "Active derivative gain", "N m s/rad", 125.8486, 377.5457, true},
    {"Kp_pass", "kp-pass", "Passive stiffness", "N m/rad", 62.9243, 377.5457, true},
    {"Kd_pass", "kd-pass", "Passive damping", "N m s/rad", 62.9243, 188.7729, true},
    {"Nv", "nv", "Vestibular noise gain", "1", 0.0, 1.0, false},
    {"theta", "theta", "Foot rotation velocity threshold", "rad/s", 0.0, 0.0052, false},
    {"delay", "delay", "Lumped delay", "s", 0.0, 0.24, false},
}};

/// The middle of every range.
inline Parameters middle_parameters() {
  Parameters p{};
  for (std::size_t i = 0; i < parameter_count; ++i) p[i] = parameter_info[i].middle();
  return p;
}

/// " N m/rad", to stand behind a number; nothing for a parameter that is a plain number.
std::string unit_after(const ParameterInfo& info);

/// "Kp=900,Kd=250,...": all seven, by name ("Kp_pass") or option name ("kp-pass"), in any order. Throws Error.
Parameters parameters_from_text(const std::string& text, const std::string& where);

}  // namespace decid::sim
