// The pendulums' steps, written once on a vector type V (base/math/doubles.hpp) and compiled once per instruction set.
// In an unnamed namespace and without the standard library, like all code compiled for more than the baseline.
#pragma once

#include "base/math/doubles.hpp"
#include "sim/kernels/pendulums.hpp"

namespace decid::sim {
namespace {

/// Terms of a trial's controller: gains of 1, other gains, and other gains with a dead band before the gravity gain.
enum class Terms { unit_gains, gains, dead_band };

/// `vectors` registers of trials that advance alternately, so that one computes during the others' latency.
template <class V, int vectors, Terms terms>
class Group {
  using D = typename V::D;
  static constexpr bool unit_gains = terms == Terms::unit_gains;

 public:
  [[gnu::always_inline]] Group(Pendulums& p, const StepConstants& step_constants, int first)
      : p_(p), step_constants_(step_constants), first_(first) {
    for (int v = 0; v < vectors; ++v) {
      sway_[v] = V::load(p.sway + lane(v));
      rate_[v] = V::load(p.sway_rate + lane(v));
      error_[v] = V::load(p.error + lane(v));
      newer_[v] = V::load(p.newer + lane(v));
      max_sway_[v] = V::load(p.max_sway + lane(v));
      noise_[v] = V::load(p.noise + lane(v));
      if constexpr (!unit_gains) {
        slow_[v] = V::load(p.slow + lane(v));
        torque_[v] = V::load(p.torque + lane(v));
        active_[v] = V::load(p.active + lane(v));
      }
    }
  }

  /// Computes one sample; returns true if all lanes are within the bound. starting: the delay has not passed for some
  /// lanes.
  template <bool starting>
  [[gnu::always_inline]] bool advance(int sample, int row) {
    D next[vectors];
    // Each lane reads its own noise, one cache line per sample: too many streams for the hardware's prefetcher. Reading
    // beyond the end is harmless.
    for (int l = first_; l < first_ + vectors * V::width; ++l) {
      __builtin_prefetch(p_.noise_rate[l] + (sample + std::ptrdiff_t{6}) * Pendulums::noise_apart);
    }
    for (int v = 0; v < vectors; ++v) {
      V::scatter(p_.samples + lane(v), sample, sway_[v]);
      next[v] =
          tilt_gain(v) * V::gather(p_.noise_rate + lane(v), (sample + std::ptrdiff_t{1}) * Pendulums::noise_apart);
      slope_[v] = (next[v] - noise_[v]) * step_constants_.per_step;
    }
    const int intervals = step_constants_.steps_per_sample / step_constants_.interval_steps;
    int step = 0;
    for (int interval = 0; interval < intervals; ++interval) {
      const std::ptrdiff_t at = 2 * (static_cast<std::ptrdiff_t>(sample) * intervals + interval);
      for (int v = 0; v < vectors; ++v) {
        const D tilt = V::gather(p_.stimulus + lane(v), at);
        const D rate = V::gather(p_.stimulus + lane(v), at + 1);
        const D passive = V::load(p_.passive + lane(v));
        drive_[v] = V::fma(passive, tilt, V::load(p_.damping + lane(v)) * rate);
        drive_slope_[v] = passive * (rate * step_constants_.step_s);
        platform_rate_[v] = tilt_gain(v) * rate;
        if constexpr (!unit_gains) excess_rate_[v] = V::load(p_.tilt_over_servo + lane(v)) * rate;
      }
      for (int i = 0; i < step_constants_.interval_steps; ++i, ++step) advance_step<starting>(row + step);
    }
    bool within = true;
    for (int v = 0; v < vectors; ++v) {
      noise_[v] = next[v];
      within = V::all_within(max_sway_[v], step_constants_.sway_limit_rad) && within;
    }
    return within;
  }

  [[gnu::always_inline]] void store() {
    for (int v = 0; v < vectors; ++v) {
      V::store(p_.sway + lane(v), sway_[v]);
      V::store(p_.sway_rate + lane(v), rate_[v]);
      V::store(p_.error + lane(v), error_[v]);
      V::store(p_.newer + lane(v), newer_[v]);
      V::store(p_.max_sway + lane(v), max_sway_[v]);
      V::store(p_.noise + lane(v), noise_[v]);
      if constexpr (!unit_gains) {
        V::store(p_.slow + lane(v), slow_[v]);
        V::store(p_.torque + lane(v), torque_[v]);
        V::store(p_.active + lane(v), active_[v]);
      }
    }
  }

 private:
  [[gnu::always_inline]] int lane(int v) const { return first_ + v * V::width; }

  /// Returns the factor of noise, platform and threshold.
  [[gnu::always_inline]] D tilt_gain(int v) const {
    if constexpr (unit_gains) return V::set(0.5);
    return V::load(p_.tilt + lane(v));
  }

  /// Computes the command; q: the rate of the tilt estimate's error. Integrates the estimates over the step.
  [[gnu::always_inline]] D command(int v, D q) {
    const D kp = V::load(p_.kp + lane(v)), kd = V::load(p_.kd + lane(v));
    D command;
    if constexpr (unit_gains) {
      command = V::fma(kp, sway_[v] + error_[v], kd * (rate_[v] + q));
    } else {
      q = q + excess_rate_[v];
      const D reach = V::load(p_.reach + lane(v));
      const D slow_rate = V::fma(V::load(p_.slow_gain + lane(v)), sway_[v], -(slow_leak_ * slow_[v]));
      const D torque_rate = V::fma(V::load(p_.torque_gain + lane(v)), active_[v], -(torque_leak_ * torque_[v]));
      D angle = V::fma(reach, sway_[v], error_[v] + (slow_[v] + torque_[v]));
      D angle_rate = V::fma(reach, rate_[v], q + (slow_rate + torque_rate));
      if constexpr (terms == Terms::dead_band) {
        const D gravity = V::load(p_.minus_gravity + lane(v));
        const D within = V::max(V::min(sway_[v], dead_band_), -dead_band_);
        angle = V::fma(gravity, within, angle);
        angle_rate = V::fma(gravity, V::abs(sway_[v]) < dead_band_ ? rate_[v] : D{}, angle_rate);
      }
      command = V::fma(kp, angle, kd * angle_rate);
      slow_[v] = V::fma(slow_rate, step_s_, slow_[v]);
      torque_[v] = V::fma(torque_rate, step_s_, torque_[v]);
    }
    error_[v] = V::fma(q, step_s_, error_[v]);
    return command;
  }

  template <bool starting>
  [[gnu::always_inline]] void advance_step(int row) {
    const std::ptrdiff_t offset = static_cast<std::ptrdiff_t>(row) * Pendulums::count;
#pragma GCC unroll 8
    for (int v = 0; v < vectors; ++v) {
      const D heard = platform_rate_[v] + noise_[v];
      const D q = noise_[v] - V::max(V::min(heard, V::load(p_.theta + lane(v))), V::load(p_.minus_theta + lane(v)));
      noise_[v] = noise_[v] + slope_[v];
      V::store(p_.commands + offset + lane(v), command(v, q));
      // A whole delay of 0 reads the value just written.
      const D newer = V::gather(p_.delayed + lane(v), offset);
      D active = V::fma(V::load(p_.fraction + lane(v)), newer_[v] - newer, newer);
      if constexpr (starting) active = V::load(p_.first_row + lane(v)) > V::set(row) ? D{} : active;
      newer_[v] = newer;
      if constexpr (!unit_gains) active_[v] = active;

      D next = V::fma(V::load(p_.k2 + lane(v)), rate_[v], drive_[v] - active);
      drive_[v] = drive_[v] + drive_slope_[v];
      next = V::fma(V::load(p_.k1 + lane(v)), sway_[v], next);
      const D z = sway_[v] * sway_[v];
      const D sine = V::fma(V::fma(V::load(p_.sine[2] + lane(v)), z, V::load(p_.sine[1] + lane(v))), z,
                            V::load(p_.sine[0] + lane(v)));
      next = V::fma(sway_[v] * z, sine, next);
      rate_[v] = next;
      sway_[v] = V::fma(next, step_s_, sway_[v]);
      // NaN comes last, so it persists to the sample's end.
      max_sway_[v] = V::max(max_sway_[v], V::abs(sway_[v]));
    }
  }

  Pendulums& p_;
  const StepConstants& step_constants_;
  int first_;
  D step_s_ = V::set(step_constants_.step_s);
  D dead_band_ = V::set(step_constants_.gravity_dead_band);
  D slow_leak_ = V::set(step_constants_.slow_leak), torque_leak_ = V::set(step_constants_.torque_leak);
  D sway_[vectors], rate_[vectors], error_[vectors], newer_[vectors], max_sway_[vectors], noise_[vectors];
  D slope_[vectors], platform_rate_[vectors], drive_[vectors], drive_slope_[vectors];
  D slow_[vectors], torque_[vectors], active_[vectors], excess_rate_[vectors];  // without unit gains only
};

template <class V, int vectors, Terms terms>
int advance_family(Pendulums& p, const StepConstants& step_constants, int samples) {
  static_assert(Pendulums::count % (vectors * V::width) == 0);
  int row = p.row;
  for (int sample = 0; sample < samples; ++sample, row += step_constants.steps_per_sample) {
    bool within = true;
    for (int first = 0; first < p.lanes; first += vectors * V::width) {
      Group<V, vectors, terms> group(p, step_constants, first);
      within = (row < p.last_first_row ? group.template advance<true>(sample, row)
                                       : group.template advance<false>(sample, row)) &&
               within;
      group.store();
    }
    if (!within) return sample + 1;
  }
  return samples;
}

template <class V, int vectors>
int advance_pendulums(Pendulums& p, const StepConstants& step_constants, int samples) {
  if (step_constants.unit_gains) return advance_family<V, vectors, Terms::unit_gains>(p, step_constants, samples);
  return step_constants.gravity_dead_band > 0.0
             ? advance_family<V, vectors, Terms::dead_band>(p, step_constants, samples)
             : advance_family<V, vectors, Terms::gains>(p, step_constants, samples);
}

}  // namespace
}  // namespace decid::sim
