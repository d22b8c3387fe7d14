// The loop of the family's members without unit gains, and its gradient: see kernels.hpp and sim/family.hpp.
#pragma once

#include "posterior/kernels/generic_matrix.hpp"
#include "posterior/kernels/generic_value.hpp"

namespace decid::posterior {
namespace {

/// One frequency of `V::width` chains. With V the platform's velocity, F the passed velocity and d = exp(-s delay):
///   C = Kp sum + Kd,  E = Kp + Kd rate,  P = Kp + Kd derivative,  X and Y the slow and the torque response,
///   A = d / (1 - d P torque Y)                    from the command without torque feedback to the active torque
///   M = (position + gravity) E + slow P X          from sway to that command
///   sway = (A C (position V - tilt F) + (Kp_pass sum + Kd_pass) V + torque) / D,
///   D = body + Kp_pass + Kd_pass rate + A M.
template <class V>
struct FamilyLoop {
  using D = typename V::D;
  using C = Value<V>;

  [[gnu::always_inline]] FamilyLoop(const LoopParameters& of, std::ptrdiff_t at)
      : kp(V::load(of.kp + at)),
        kd(V::load(of.kd + at)),
        kp_pass(V::load(of.kp_pass + at)),
        kd_pass(V::load(of.kd_pass + at)),
        position(V::load(of.position + at)),
        tilt(V::load(of.tilt + at)),
        gravity(V::load(of.gravity + at)),
        slow(V::load(of.slow + at)),
        torque(V::load(of.torque + at)) {}

  [[gnu::always_inline]] void turn_to(const LoopConstants& constants, std::ptrdiff_t k, C delay) {
    sum = C::same(constants.sum + 2 * k);
    rate = C::same(constants.rate + 2 * k);
    derivative = C::same(constants.derivative + 2 * k);
    platform = C::same(constants.platform + 2 * k);
    slow_response = C::same(constants.slow_response + 2 * k);
    torque_response = C::same(constants.torque_response + 2 * k);
    c = {V::fma(kp, sum.re, kd), kp * sum.im};
    e = {V::fma(kd, rate.re, kp), kd * rate.im};
    p = {V::fma(kd, derivative.re, kp), kd * derivative.im};
    const C fed_back = delay * (p * torque_response) * torque, one{V::set(1.0), V::set(0.0)};
    closed = C::quotient(one, one - fed_back);
    active = delay * closed;
    returned = C::sum(e * (position + gravity), p * slow_response, slow);
  }
  /// Returns position V - tilt F.
  [[gnu::always_inline]] C error(C passed) const { return C::sum(platform * position, passed, -tilt); }

  D kp, kd, kp_pass, kd_pass, position, tilt, gravity, slow, torque;
  C sum, rate, derivative, platform, slow_response, torque_response;
  C c, e, p, closed, active, returned;
};

template <class V>
void family_loop(const LoopConstants& constants, const LoopParameters& parameters, const LoopState& state) {
  using C = Value<V>;
  for (int v = 0; v < vectors<V>; ++v) {
    const std::ptrdiff_t at = v * V::width;
    FamilyLoop<V> p(parameters, at);
    const typename V::D gain = V::load(parameters.gain + at);
    C delayed = C::load(parameters.delay_first, 0, v), shifted = C::load(parameters.start_first, 0, v);
    const C delay_turn = C::load(parameters.delay_turn, 0, v), start_turn = C::load(parameters.start_turn, 0, v);
    for (std::ptrdiff_t k = 0; k < constants.count; ++k) {
      p.turn_to(constants, k, delayed);
      const C passed =
          C::load(state.passed, k, v) * C::same(constants.hold + 2 * k) + C::same(constants.unbinned + 2 * k);
      C d = C::same(constants.body + 2 * k);
      d.re = d.re + p.kp_pass;
      d = C::sum(d, p.rate, p.kd_pass) + p.active * p.returned;
      const C inverse = C::quotient({V::set(1.0), V::set(0.0)}, d);
      const C ankle{V::fma(p.kp_pass, p.sum.re, p.kd_pass), p.kp_pass * p.sum.im};
      const C drive = p.active * (p.c * p.error(passed)) + (ankle * p.platform + C::same(constants.torque + 2 * k));
      const C sway = drive * inverse, observe = C::same(constants.observe + 2 * k) * shifted;
      passed.store(state.passed, k, v);
      delayed.store(state.delayed, k, v);
      inverse.store(state.inverse, k, v);
      sway.store(state.sway, k, v);
      observe.store(state.observe, k, v);
      (sway * observe * gain).store(state.observed, k, v);
      delayed = delayed * delay_turn;
      shifted = shifted * start_turn;
    }
  }
}

/// With N = C error - M sway, the command behind the active torque, a change of A moves the sway by N / D, and
/// dA = A^2 (torque Y dP + P Y dtorque) + (A / (1 - d P torque Y)) (-s) ddelay.
template <class V>
void family_loop_gradient(const LoopConstants& constants, const LoopParameters& parameters, const LoopState& state,
                          const LoopGradient& gradient) {
  using D = typename V::D;
  using C = Value<V>;
  for (int v = 0; v < vectors<V>; ++v) {
    const std::ptrdiff_t at = v * V::width;
    FamilyLoop<V> p(parameters, at);
    const D gain = V::load(parameters.gain + at), zero = V::set(0.0);
    D by_kp = zero, by_kd = zero, by_kp_pass = zero, by_kd_pass = zero, by_delay = zero, by_start = zero,
      by_gain = zero, by_position = zero, by_tilt = zero, by_gravity = zero, by_slow = zero, by_torque = zero;
    for (std::ptrdiff_t k = 0; k < constants.count; ++k) {
      const C sway = C::load(state.sway, k, v), s = C::same(constants.s + 2 * k);
      p.turn_to(constants, k, C::load(state.delayed, k, v));
      const C passed = C::load(state.passed, k, v), error = p.error(passed);
      // All frequencies except 0 represent two, above and below it.
      const D back = V::set(k == 0 ? 0.5 * constants.back : constants.back);
      C by_observed = C::load(gradient.by_observed, k, v);
      by_observed = {by_observed.re * back, -(by_observed.im * back)};
      const C by_observed_sway = by_observed * C::load(state.observe, k, v);
      by_gain = by_gain + C::real_product(by_observed_sway, sway);
      const C by_sway = by_observed_sway * gain;
      by_start = by_start + C::real_product(by_sway, s * sway);
      const C by_drive = by_sway * C::load(state.inverse, k, v);
      const C by_command = by_drive * p.active;
      const C command = p.c * error - p.returned * sway;
      const C by_loop = by_command * p.active * command;  // by the inverse of A
      const C of_p = by_command * (p.slow_response * sway) * p.slow - by_loop * p.torque_response * p.torque;
      const C reached = sway * (p.position + p.gravity);
      by_kp = by_kp + (C::real_product(by_command, p.sum * error - reached) - of_p.re);
      by_kd = by_kd + (C::real_product(by_command, error - p.rate * reached) - C::real_product(of_p, p.derivative));
      by_kp_pass = by_kp_pass + C::real_product(by_drive, p.sum * p.platform - sway);
      by_kd_pass = by_kd_pass + C::real_product(by_drive, p.platform - p.rate * sway);
      by_delay = by_delay - C::real_product(by_command * p.closed, s * command);
      const C by_angle = by_command * p.c, of_body = by_command * p.e;
      const D fallen = C::real_product(of_body, sway);
      by_position = by_position + (C::real_product(by_angle, p.platform) - fallen);
      by_tilt = by_tilt - C::real_product(by_angle, passed);
      by_gravity = by_gravity - fallen;
      by_slow = by_slow - C::real_product(by_command, p.p * (p.slow_response * sway));
      by_torque = by_torque + C::real_product(by_loop, p.p * p.torque_response);
      const C by_passed = by_angle * C::same(constants.hold + 2 * k) * p.tilt;
      const D single = V::set(k == 0 ? 2.0 : 1.0);
      C{-(by_passed.re * single), by_passed.im * single}.store(gradient.by_passed, k, v);
    }
    const D sums[] = {by_kp,   by_kd,       by_kp_pass, by_kd_pass, by_delay, by_start,
                      by_gain, by_position, by_tilt,    by_gravity, by_slow,  by_torque};
    for (std::size_t i = 0; i < loop_sums; ++i)
      V::store(gradient.sums + static_cast<std::ptrdiff_t>(i) * lanes + at, sums[i]);
  }
}

}  // namespace
}  // namespace decid::posterior
