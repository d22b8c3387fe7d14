// The family of controllers that decid simulates and fits: a servo behind a dead band. One member is a table of
// parameters and a Family, which says how the parameters make the coefficients below. a = body in space, f = platform
// in space, nu = vestibular noise, all rad; u at t - delay, zero before:
//
//   e' = tilt f_theta(f' + nu')                          estimate of the platform's tilt
//   v  = position (a - f) + e + gravity a + q + r        the angle that the controller acts on
//   q' = slow a - q / slow_time                          slow feedback of the body's angle
//   r' = torque u / (m g h) - r / torque_time            positive feedback of the active torque
//   u  = kp v + kd v'
//   J a'' = m g h sin(a) - u(t - delay) - kp_pass (a - f) - kd_pass (a' - f')
//
// The dead band never acts on the body, so everything behind it is linear. Sources: the members' files in sim/models.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "sim/parameters.hpp"

namespace decid::sim {

enum class Coefficient : std::size_t {
  kp,        ///< N m/rad
  kd,        ///< N m s/rad
  kp_pass,   ///< N m/rad
  kd_pass,   ///< N m s/rad
  nv,        ///< of the vestibular noise
  theta,     ///< rad/s
  delay,     ///< s
  position,  ///< of the ankle angle in the servo
  tilt,      ///< of the tilt estimate
  gravity,   ///< of the body's angle
  slow,      ///< 1/s
  torque     ///< 1/s
};

/// Values of all coefficients.
class Coefficients {
 public:
  static constexpr std::size_t count = 12;

  constexpr double& operator[](Coefficient c) noexcept { return values_[static_cast<std::size_t>(c)]; }
  constexpr double operator[](Coefficient c) const noexcept { return values_[static_cast<std::size_t>(c)]; }

 private:
  std::array<double, count> values_{};
};

/// The coefficients as affine functions of a member's parameters.
struct Family {
  /// Adds factor * parameter to a coefficient.
  struct Term {
    std::size_t parameter;
    Coefficient coefficient;
    double factor = 1.0;
  };
  Coefficients constant{};
  std::vector<Term> terms;
  double slow_time_s = 15.0, torque_time_s = 20.0;

  Coefficients coefficients(const Parameters& parameters) const;
  /// Returns true if a term depends on the parameters or the constant differs from `value`.
  bool varies(Coefficient coefficient, double value) const;
  /// Returns true for members with gains of 1 and neither slow nor torque feedback, as in the paper: their trials take
  /// fewer operations.
  bool has_unit_gains() const;
  /// Returns the parameter that alone determines a coefficient; nothing if it is constant or depends on several.
  std::optional<std::size_t> find_parameter(Coefficient coefficient) const;
  /// Returns the parameters with those of the vestibular noise set to 0.
  Parameters without_noise(Parameters parameters) const;
};

}  // namespace decid::sim
