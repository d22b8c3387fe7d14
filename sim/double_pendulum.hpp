// A trial of the double inverted pendulum: leg and trunk on the tilting platform, a DEC controller at the ankle and one
// at the hip, 1 ms semi-implicit Euler. Conventions are those of sim/simulate.hpp. p1 leg in space, p2 trunk in space,
// f platform in space, a the body's centre of mass in space, rad:
//   a   = (m_L h_L p1 + m_T (l_L p1 + h_T p2)) / ((m_L + m_T) h)
//   A1  = m_L h_L^2 + m_T l_L^2 + J_L,  A2 = m_T h_T^2 + J_T,  B = m_T l_L h_T
//   A1 p1'' + B cos(p1 - p2) p2'' = t_ankle - t_hip - B p2'^2 sin(p1 - p2) + g (m_L h_L + m_T l_L) sin p1
//   B cos(p1 - p2) p1'' + A2 p2'' = t_hip + B p1'^2 sin(p1 - p2) + g m_T h_T sin p2
// Ankle: the single pendulum's controller with a; its passive part acts on the joint, p1 - f. Hip: the same form with
// the trunk for the body and the leg for its support, a -> p2, f -> p1, passive on p2 - p1; e_h' = f_theta(p1' + nu'):
//   t_ankle = -u_a(t - delay_a) - Kp_pass (p1 - f) - Kd_pass (p1' - f'),    u_a = Kp (2a + e - f) + Kd (2a' + e' - f')
//   t_hip   = -u_h(t - delay_h) - Kp_pass (p2 - p1) - Kd_pass (p2' - p1'),  u_h = Kp (2p2 + e_h - p1) + Kd (...)'
// Modules: Lippi and Mergner, Front Neurorobot 11, 2017. Segments: sim/segments.hpp.
#pragma once

#include <span>

#include "base/math/random.hpp"
#include "sim/segments.hpp"
#include "sim/simulate.hpp"

namespace decid::sim {

/// The bound of both segments, about 29 degrees. A trial is valid while, over every step, the segments stay within it
/// and the centre of mass within sway_limit_rad. (Leg and trunk may lean against each other while the centre of mass is
/// upright.)
inline constexpr double segment_limit_rad = 0.5;

struct DoubleState {
  double leg_rad = 0.0, trunk_rad = 0.0;
  double leg_rate = 0.0, trunk_rate = 0.0;  ///< rad/s
};

/// The mechanics without controllers.
class DoubleBody {
 public:
  explicit DoubleBody(const Segments& segments);

  struct Accelerations {
    double leg, trunk;  ///< rad/s^2
  };
  /// Returns the accelerations. Torques in N m are positive towards positive angles: the ankle's on the leg, the hip's
  /// on the trunk (and its opposite on the leg). Angles must be within segment_limit_rad.
  Accelerations accelerations(const DoubleState& state, double ankle_torque, double hip_torque) const;
  /// Makes one semi-implicit Euler step: accelerations from the state at its start, velocities first.
  void step(DoubleState& state, double ankle_torque, double hip_torque, double dt_s) const;
  /// Returns the centre of mass's a from p1 and p2, or its a' from p1' and p2'.
  double centre_of_mass(double leg, double trunk) const { return leg_weight_ * leg + trunk_weight_ * trunk; }

 private:
  double leg_inertia_, trunk_inertia_, coupling_;  // A1, A2, B
  double leg_gravity_, trunk_gravity_;             // g times m_L h_L + m_T l_L, and m_T h_T
  double leg_weight_, trunk_weight_;               // weights of the centre of mass
};

/// Seven parameters per joint, as in sim/parameters.hpp.
struct DoubleParameters {
  Parameters ankle, hip;
};
/// Returns default gains as fractions of the gravitational stiffness: m g h of the whole body at the ankle and m_T g
/// h_T at the hip. Ankle: Kp .9, Kd .275, Kp_pass .15, Kd_pass .15, Nv .5, theta .0026, delay .16 s; hip: Kp .8, Kd
/// .175, Kp_pass .5, Kd_pass .15, Nv 0, theta .0026, delay .07 s. The values are decid's own, near those of the DEC
/// literature.
DoubleParameters default_double_parameters(const Segments& segments);

/// The output of a trial; samples() values each.
struct DoubleSway {
  std::span<double> com_rad, leg_rad, trunk_rad;
};

/// Simulates trials of one protocol. Immutable: all threads may share it.
class DoubleSimulator {
 public:
  /// Takes the segments from the protocol's body (make_participant). The joints have the controller dec: the protocol's
  /// own controller and its gravity_dead_band_deg have no effect. Throws Error if the protocol is invalid, or if its
  /// body does not consist of Winter's segments.
  explicit DoubleSimulator(Protocol protocol);

  const Protocol& protocol() const noexcept { return protocol_; }
  const Segments& segments() const noexcept { return segments_; }
  const Stimulus& stimulus() const noexcept { return stimulus_; }
  int samples() const noexcept { return samples_; }

  /// Simulates one trial from rest, upright, or after the protocol's standing, as Simulator::run does; max_sway_rad is
  /// the centre of mass's. If the trial exceeds a bound, end_s is the end of that step, not of its sample period. The
  /// hip's vestibular noise is the ankle's realisation with its own Nv, because one head senses both. Throws Error for
  /// a non-finite or negative parameter, a delay above longest_delay_s, or spans of another length.
  Outcome run(const DoubleParameters& parameters, const Random& noise, const DoubleSway& sway) const;

 private:
  Protocol protocol_;
  Segments segments_;
  Stimulus stimulus_;
  int samples_;
  Protocol whole_;  // including the standing
  Stimulus whole_stimulus_;
  VestibularNoiseMaker noise_maker_;
};

}  // namespace decid::sim
