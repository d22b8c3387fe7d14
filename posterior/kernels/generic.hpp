// The kernels of the posterior density, written once on a vector type V (base/math/doubles.hpp) and compiled once per
// instruction set. kernels.hpp documents them.
#pragma once

#include "base/math/doubles.hpp"
#include "posterior/kernels/generic_family.hpp"
#include "posterior/kernels/generic_matrix.hpp"
#include "posterior/kernels/generic_noise.hpp"
#include "posterior/kernels/generic_value.hpp"

namespace decid::posterior {
namespace {

template <class V>
[[gnu::always_inline]] inline typename V::D beyond(typename V::D x, typename V::D theta) {
  return x - V::max(V::min(x, theta), -theta);
}

/// A velocity runs from a to b. The mean of f_theta is (f(b)^2 - f(a)^2) / (2 (b - a)) = fraction (f(a) + f(b)) / 2
/// with fraction = (f(b) - f(a)) / (b - a), the part of the bin outside of the dead band.
template <class V>
void dead_band(const DeadBandBins& bins, const DeadBandValues& values) {
  using D = typename V::D;
  const D tiny = V::set(1e-9), zero = V::set(0.0), one = V::set(1.0), half = V::set(0.5);
  for (int v = 0; v < vectors<V>; ++v) {
    const std::ptrdiff_t at = v * V::width;
    const D gain = V::load(values.gain + at), theta = V::load(values.theta + at);
    D noise = V::load(values.noise + at);
    for (std::ptrdiff_t bin = 0; bin < bins.count; ++bin) {
      const D next = V::load(values.noise + (bin + 1) * lanes + at);
      const D low = V::fma(gain, noise, V::set(bins.rate_low[bin]));
      const D high = V::fma(gain, next, V::set(bins.rate_high[bin]));
      noise = next;
      const D f_low = beyond<V>(low, theta), f_high = beyond<V>(high, theta);
      const D run = high - low;
      const auto flat = V::abs(run) < tiny;
      const D outside = (f_low == zero) ? zero : one;
      const D inverse = one / (flat ? one : run);
      const D fraction = flat ? outside : (f_high - f_low) * inverse;
      const D mean = half * (f_low + f_high) * fraction;
      const D by_low = flat ? half * outside : (mean - f_low) * inverse;
      const D by_high = flat ? half * outside : (f_high - mean) * inverse;
      const D sign = f_low < zero ? -one : one;
      const D by_theta = flat ? -(sign * outside) : (V::abs(f_low) - V::abs(f_high)) * inverse;
      const D weight = V::set(bins.weight[bin]);
      const std::ptrdiff_t to = bin * lanes + at;
      V::store(values.passed + to, weight * mean);
      V::store(values.by_noise_low + to, weight * by_low);
      V::store(values.by_noise_high + to, weight * by_high);
      V::store(values.by_theta + to, weight * by_theta);
    }
  }
}

template <class V>
void refine(int count, const double* coarse, double* fine) {
  using D = typename V::D;
  const D nine = V::set(9.0 / 16), one = V::set(1.0 / 16), half = V::set(0.5);
  for (int v = 0; v < vectors<V>; ++v) {
    const double* in = coarse + v * V::width;
    double* out = fine + v * V::width;
    const auto at = [in](std::ptrdiff_t i) { return V::load(in + i * lanes); };
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      V::store(out + 2 * i * lanes, at(i));
      if (i + 1 == count) break;
      const D near = at(i) + at(i + 1);
      const bool inner = i > 0 && i + 2 < count;
      V::store(out + (2 * i + 1) * lanes, inner ? V::fma(nine, near, -(one * (at(i - 1) + at(i + 2)))) : half * near);
    }
  }
}

template <class V>
void refine_gradient(int count, const double* by_fine, double* by_coarse) {
  using D = typename V::D;
  const D nine = V::set(9.0 / 16), one = V::set(1.0 / 16), half = V::set(0.5);
  for (int v = 0; v < vectors<V>; ++v) {
    const double* in = by_fine + v * V::width;
    double* out = by_coarse + v * V::width;
    // The contributions of the point after value i to an adjacent value and to a farther one; zero before and after the
    // range.
    const auto between = [in](std::ptrdiff_t i) { return V::load(in + (2 * i + 1) * lanes); };
    const auto inner = [count](std::ptrdiff_t i) { return i > 0 && i + 2 < count; };
    const auto beside = [&](std::ptrdiff_t i, D sum) {
      if (i < 0 || i + 1 >= count) return sum;
      return V::fma(inner(i) ? nine : half, between(i), sum);
    };
    const auto farther = [&](std::ptrdiff_t i, D sum) {
      return i >= 0 && inner(i) ? V::fma(-one, between(i), sum) : sum;
    };
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      const D own = V::load(in + 2 * i * lanes);
      V::store(out + i * lanes, farther(i + 1, farther(i - 2, beside(i, beside(i - 1, own)))));
    }
  }
}

template <class V>
void join(int count, const double* halves, double* bins) {
  using D = typename V::D;
  const D half = V::set(0.5), twelfth = V::set(1.0 / 12), zero = V::set(0.0);
  for (int v = 0; v < vectors<V>; ++v) {
    const double* in = halves + v * V::width;
    double* out = bins + v * V::width;
    const auto sum = [&](std::ptrdiff_t i) { return V::load(in + 2 * i * lanes) + V::load(in + (2 * i + 1) * lanes); };
    const auto difference = [&](std::ptrdiff_t i) {
      if (i < 0 || i >= count) return zero;
      return V::load(in + (2 * i + 1) * lanes) - V::load(in + 2 * i * lanes);
    };
    D before = zero, here = difference(0);
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      const D next = difference(i + 1);
      V::store(out + i * lanes, V::fma(twelfth, before - next, half * sum(i)));
      before = here;
      here = next;
    }
  }
}

template <class V>
void join_gradient(int count, const double* by_bins, double* by_halves) {
  using D = typename V::D;
  const D half = V::set(0.5), twelfth = V::set(1.0 / 12), zero = V::set(0.0);
  for (int v = 0; v < vectors<V>; ++v) {
    const double* in = by_bins + v * V::width;
    double* out = by_halves + v * V::width;
    D before = zero, here = V::load(in);
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      const D next = i + 1 < count ? V::load(in + (i + 1) * lanes) : zero;
      const D moved = twelfth * (next - before);
      V::store(out + 2 * i * lanes, V::fma(half, here, -moved));
      V::store(out + (2 * i + 1) * lanes, V::fma(half, here, moved));
      before = here;
      here = next;
    }
  }
}

template <class V>
void dead_band_gradient(const DeadBandBins& bins, const DeadBandValues& values, const DeadBandGradient& gradient) {
  using D = typename V::D;
  for (int v = 0; v < vectors<V>; ++v) {
    const std::ptrdiff_t at = v * V::width;
    D by_theta = V::set(0.0), by_gain = V::set(0.0), from_before = V::set(0.0);
    for (std::ptrdiff_t bin = 0; bin < bins.count; ++bin) {
      const std::ptrdiff_t to = bin * lanes + at;
      const D by_passed = V::load(gradient.by_passed + to);
      const D by_noise = V::fma(by_passed, V::load(values.by_noise_low + to), from_before);
      from_before = by_passed * V::load(values.by_noise_high + to);
      V::store(gradient.by_noise + to, by_noise);
      by_gain = V::fma(by_noise, V::load(values.noise + to), by_gain);
      by_theta = V::fma(by_passed, V::load(values.by_theta + to), by_theta);
    }
    const std::ptrdiff_t end = std::ptrdiff_t{bins.count} * lanes + at;
    V::store(gradient.by_noise + end, from_before);
    by_gain = V::fma(from_before, V::load(values.noise + end), by_gain);
    V::store(gradient.by_gain + at, by_gain);
    V::store(gradient.by_theta + at, by_theta);
  }
}

/// With V the platform's velocity and F the passed velocity, C = Kp sum + Kd, E = Kp + Kd rate:
///   sway = (delayed C (V - F) + (Kp_pass sum + Kd_pass) V + torque) / D,
///   D = body + Kp_pass + Kd_pass rate + 2 delayed E.
template <class V>
struct Loop {
  using D = typename V::D;
  D kp, kd, kp_pass, kd_pass;

  [[gnu::always_inline]] Loop(const LoopParameters& p, std::ptrdiff_t at)
      : kp(V::load(p.kp + at)),
        kd(V::load(p.kd + at)),
        kp_pass(V::load(p.kp_pass + at)),
        kd_pass(V::load(p.kd_pass + at)) {}
  [[gnu::always_inline]] Value<V> c(Value<V> sum) const { return {V::fma(kp, sum.re, kd), kp * sum.im}; }
  [[gnu::always_inline]] Value<V> e(Value<V> rate) const { return {V::fma(kd, rate.re, kp), kd * rate.im}; }
};

template <class V>
void loop(const LoopConstants& constants, const LoopParameters& parameters, const LoopState& state) {
  using D = typename V::D;
  using C = Value<V>;
  for (int v = 0; v < vectors<V>; ++v) {
    const std::ptrdiff_t at = v * V::width;
    const Loop<V> p(parameters, at);
    const D gain = V::load(parameters.gain + at), two = V::set(2.0), one = V::set(1.0);
    C delayed = C::load(parameters.delay_first, 0, v), shifted = C::load(parameters.start_first, 0, v);
    const C delay_turn = C::load(parameters.delay_turn, 0, v), start_turn = C::load(parameters.start_turn, 0, v);
    for (std::ptrdiff_t k = 0; k < constants.count; ++k) {
      const C sum = C::same(constants.sum + 2 * k), rate = C::same(constants.rate + 2 * k);
      const C platform = C::same(constants.platform + 2 * k);
      const C passed =
          C::load(state.passed, k, v) * C::same(constants.hold + 2 * k) + C::same(constants.unbinned + 2 * k);
      const C e = p.e(rate);
      C d = C::same(constants.body + 2 * k);
      d.re = d.re + p.kp_pass;
      d = C::sum(d, rate, p.kd_pass);
      d = C::sum(d, delayed * e, two);
      const D scale = one / V::fma(d.re, d.re, d.im * d.im);
      const C inverse{d.re * scale, -(d.im * scale)};
      const C ankle{V::fma(p.kp_pass, sum.re, p.kd_pass), p.kp_pass * sum.im};
      const C drive =
          delayed * (p.c(sum) * (platform - passed)) + (ankle * platform + C::same(constants.torque + 2 * k));
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

template <class V>
void loop_gradient(const LoopConstants& constants, const LoopParameters& parameters, const LoopState& state,
                   const LoopGradient& gradient) {
  using D = typename V::D;
  using C = Value<V>;
  for (int v = 0; v < vectors<V>; ++v) {
    const std::ptrdiff_t at = v * V::width;
    const Loop<V> p(parameters, at);
    const D gain = V::load(parameters.gain + at), two = V::set(2.0);
    D by_kp = V::set(0.0), by_kd = by_kp, by_kp_pass = by_kp, by_kd_pass = by_kp, by_delay = by_kp, by_start = by_kp,
      by_gain = by_kp;
    for (std::ptrdiff_t k = 0; k < constants.count; ++k) {
      const C sum = C::same(constants.sum + 2 * k), rate = C::same(constants.rate + 2 * k);
      const C platform = C::same(constants.platform + 2 * k), s = C::same(constants.s + 2 * k);
      const C delayed = C::load(state.delayed, k, v), sway = C::load(state.sway, k, v);
      const C error = platform - C::load(state.passed, k, v);
      // All frequencies except 0 represent two, above and below it.
      const D back = V::set(k == 0 ? 0.5 * constants.back : constants.back);
      C by_observed = C::load(gradient.by_observed, k, v);
      by_observed = {by_observed.re * back, -(by_observed.im * back)};
      const C by_observed_sway = by_observed * C::load(state.observe, k, v);
      by_gain = by_gain + C::real_product(by_observed_sway, sway);
      const C by_sway = by_observed_sway * gain;
      by_start = by_start + C::real_product(by_sway, s * sway);
      const C by_drive = by_sway * C::load(state.inverse, k, v);
      const C by_active = by_drive * delayed;
      const C c_error = p.c(sum) * error, twice_sway = sway * two;
      by_kp = by_kp + C::real_product(by_active, sum * error - twice_sway);
      by_kd = by_kd + C::real_product(by_active, error - rate * twice_sway);
      by_kp_pass = by_kp_pass + C::real_product(by_drive, sum * platform - sway);
      by_kd_pass = by_kd_pass + C::real_product(by_drive, platform - rate * sway);
      by_delay = by_delay - C::real_product(by_active, s * (c_error - p.e(rate) * twice_sway));
      const C by_passed = by_active * p.c(sum) * C::same(constants.hold + 2 * k);
      const D single = V::set(k == 0 ? 2.0 : 1.0);
      C{-(by_passed.re * single), by_passed.im * single}.store(gradient.by_passed, k, v);
    }
    const D sums[] = {by_kp, by_kd, by_kp_pass, by_kd_pass, by_delay, by_start, by_gain};
    for (int i = 0; i < 7; ++i) V::store(gradient.sums + i * lanes + at, sums[i]);
  }
}

template <class V>
void turn(int count, const double* in, const double* factors, double* out) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const Value<V> factor = Value<V>::same(factors + 2 * i);
    for (int v = 0; v < vectors<V>; ++v) (Value<V>::load(in, i, v) * factor).store(out, i, v);
  }
}

template <class V>
void add_conjugate_product(int count, const double* in, const double* factors, double* out) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    for (int v = 0; v < vectors<V>; ++v) {
      const double* factor = factors + 2 * i;
      const Value<V> a = Value<V>::load(in, i, v), b = Value<V>::load(out, i, v);
      const typename V::D re = V::set(factor[0]), im = V::set(factor[1]);
      Value<V>{V::fma(a.im, im, V::fma(a.re, re, b.re)), V::fma(-a.re, im, V::fma(a.im, re, b.im))}.store(out, i, v);
    }
  }
}

template <class V>
void scale(int count, const double* in, const double* factors, double* out) {
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const typename V::D factor = V::set(factors[i]);
    for (int v = 0; v < vectors<V>; ++v) {
      const std::ptrdiff_t at = i * lanes + v * V::width;
      V::store(out + at, V::load(in + at) * factor);
    }
  }
}

/// passed = by_noise_low n[bin] + by_noise_high n[bin + 1].
template <class V>
void dead_band_change(int count, const DeadBandValues& values, const double* noise, double* passed) {
  using D = typename V::D;
  for (std::ptrdiff_t bin = 0; bin < count; ++bin) {
    const D low = V::set(noise[bin]), high = V::set(noise[bin + 1]);
    for (int v = 0; v < vectors<V>; ++v) {
      const std::ptrdiff_t at = bin * lanes + v * V::width;
      V::store(passed + at, V::fma(V::load(values.by_noise_low + at), low, V::load(values.by_noise_high + at) * high));
    }
  }
}

template <class V>
void product(int count, const double* a, const double* b, double* out) {
  for (std::ptrdiff_t k = 0; k < count; ++k) {
    for (int v = 0; v < vectors<V>; ++v) (Value<V>::load(a, k, v) * Value<V>::load(b, k, v)).store(out, k, v);
  }
}

template <class V>
constexpr Kernels kernel_table{.dead_band = dead_band<V>,
                               .dead_band_gradient = dead_band_gradient<V>,
                               .refine = refine<V>,
                               .refine_gradient = refine_gradient<V>,
                               .join = join<V>,
                               .join_gradient = join_gradient<V>,
                               .dead_band_change = dead_band_change<V>,
                               .loop = loop<V>,
                               .loop_gradient = loop_gradient<V>,
                               .family_loop = family_loop<V>,
                               .family_loop_gradient = family_loop_gradient<V>,
                               .product = product<V>,
                               .turn = turn<V>,
                               .add_conjugate_product = add_conjugate_product<V>,
                               .scale = scale<V>,
                               .unfold = unfold<V>,
                               .fold = fold<V>,
                               .noise_rows = noise_rows<V>,
                               .noise_rows_gradient = noise_rows_gradient<V>,
                               .whiten = whiten<V>,
                               .missing_matrix = missing_matrix<V>,
                               .add_to_distances = add_to_distances<V>,
                               .columns_times = columns_times<V>,
                               .missing_powers = missing_powers<V>,
                               .lower_times = lower_times<V>,
                               .upper_times = upper_times<V>,
                               .add_matrix_times = add_matrix_times<V>,
                               .factorize = factorize<V>,
                               .solve_lower = solve_lower<V>,
                               .solve_transposed = solve_transposed<V>,
                               .inverse_of_factor = inverse_of_factor<V>,
                               .symmetric_times = symmetric_times<V>,
                               .stretch = stretch<V>,
                               .stretch_gradient = stretch_gradient<V>,
                               .add_times = add_times<V>,
                               .subtract_times = subtract_times<V>,
                               .with_prior = with_prior<V>,
                               .squares = squares<V>,
                               .add_products = add_products<V>,
                               .inverse_factor = inverse_factor<V>};

}  // namespace
}  // namespace decid::posterior
