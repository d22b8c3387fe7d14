// Elementary functions on a vector type V (base/math/doubles.hpp): see math.hpp for their bounds. With one lane they
// equal the functions there. Both sides of every choice are computed, so a lane's bits do not depend on its neighbours.
// They depend on compiler options (cmake/DecidTargets.cmake), so this header is not installed. Reductions: log as in
// fdlibm (Sun, 1993); atan by the difference of angles at an eighth of a turn. Polynomials: Taylor for log, the best of
// its degree (Remez exchange in 60 digits) for atan. Normal deviates: Wichura, algorithm AS 241 (PPND16), Applied
// Statistics 37, 1988; coefficients as printed there.
#pragma once

#include "base/math/doubles.hpp"

namespace decid {
namespace {

constexpr double pi_hi = 0x1.921fb54442d18p+1, pi_lo = 0x1.1a62633145c07p-53;
constexpr double three_quarters_hi = 0x1.2d97c7f3321d2p+1, three_quarters_lo = 0x1.a79394c9e8a0ap-54;  // of pi
// ln2_hi ends in 21 zero bits: its product with an exponent is exact.
constexpr double ln2_hi = 6.93147180369123816490e-01, ln2_lo = 1.90821492927058770002e-10;

/// Returns sin(x) for |x| <= 0.5: Taylor to x^15 in two halves, whose chain of dependent operations is half as long as
/// Horner's.
template <class D>
[[gnu::always_inline]] inline D sin_small_lanes(D x) {
  const D z = x * x;
  const D z2 = z * z;
  const D low = (z * (1.0 / 120) - 1.0 / 6) + z2 * (z * (1.0 / 362880) - 1.0 / 5040);
  const D high = (z * (1.0 / 6227020800) - 1.0 / 39916800) - z2 * (1.0 / 1307674368000);
  return x + x * z * (low + z2 * z2 * high);
}

/// Returns cos(x) for |x| <= 0.5: Taylor to x^14.
template <class D>
[[gnu::always_inline]] inline D cos_small_lanes(D x) {
  const D z = x * x;
  const D z2 = z * z;
  const D low = (1.0 / 24 - z * (1.0 / 720)) + z2 * (1.0 / 40320 - z * (1.0 / 3628800));
  const D high = 1.0 / 479001600 - z * (1.0 / 87178291200);
  // 1 - z / 2 is rounded; its rounding error joins the small terms.
  const D half = 0.5 * z;
  const D top = 1.0 - half;
  return top + (((1.0 - top) - half) + z2 * (low + z2 * z2 * high));
}

template <class V, class D = typename V::D>
[[gnu::always_inline]] inline D log_lanes(D x) {
  constexpr double sqrt_2 = 1.4142135623730951;
  const auto bits = V::bits(x);
  // The exponent's 11 bits at the lower end of a double that is larger by 2^52.
  D exponent = V::from_bits(((bits >> 52) & V::set_bits(0x7ff)) | V::set_bits(0x4330000000000000)) - (0x1p52 + 1023.0);
  D mantissa = V::from_bits((bits & V::set_bits(0x000fffffffffffff)) | V::set_bits(0x3ff0000000000000));
  const auto large = mantissa > V::set(sqrt_2);
  mantissa = large ? mantissa * 0.5 : mantissa;
  exponent = large ? exponent + 1.0 : exponent;
  // log(1 + f) = 2 atanh(s), s = f / (2 + f), written as f - (f^2 / 2 - s (f^2 / 2 + R)): the large parts are exact.
  const D f = mantissa - 1.0;
  const D s = f / (2.0 + f);
  const D z = s * s;
  D r = V::set(2.0 / 21);
  r = r * z + 2.0 / 19;
  r = r * z + 2.0 / 17;
  r = r * z + 2.0 / 15;
  r = r * z + 2.0 / 13;
  r = r * z + 2.0 / 11;
  r = r * z + 2.0 / 9;
  r = r * z + 2.0 / 7;
  r = r * z + 2.0 / 5;
  r = r * z + 2.0 / 3;
  r = r * z;
  const D half_square = 0.5 * f * f;
  return exponent * ln2_hi - ((half_square - (s * (half_square + r) + exponent * ln2_lo)) - f);
}

template <class V, class D = typename V::D>
[[gnu::always_inline]] inline D asinh_lanes(D x) {
  constexpr double largest = 0x1.fffffffffffffp1023;
  const D a = V::abs(x);
  // Above 2^28, x^2 + 1 = x^2 and asinh = log(2 a). Below, log(1 + y) = log(u) + log((1 + y) / u), u = 1 + y rounded,
  // where (1 + y) / u differs from 1 only by the rounding error.
  const auto big = a > V::set(0x1p28);
  const D y = a + a * a / (1.0 + V::sqrt(a * a + 1.0));
  const D u = 1.0 + y;
  const D lost = y < V::set(1.0) ? y - (u - 1.0) : 1.0 - (u - y);
  const D value = log_lanes<V>(big ? a : u) + (big ? V::set(ln2_hi + ln2_lo) : lost / u);
  const D result = x < V::set(0.0) ? -value : value;
  return a <= V::set(largest) ? result : x;  // asinh of an infinity or NaN is itself
}

template <class V, class D = typename V::D>
[[gnu::always_inline]] inline D atan2_lanes(D y, D x) {
  const D zero = V::set(0.0), infinity = V::set(__builtin_inf());
  const D width = V::abs(x), height = V::abs(y);
  const auto steep = height > width;
  D small = steep ? width : height, large = steep ? height : width;
  // Two infinities give 1 / 1, one gives 0 / 1; 0 / 0 gives 0 / 1.
  small = large == infinity ? (small == infinity ? V::set(1.0) : zero) : small;
  large = large == infinity ? V::set(1.0) : large;
  large = large == zero ? V::set(1.0) : large;
  // Powers of two are exact; sums of the two can neither overflow nor lose bits to underflow.
  const D scale =
      large > V::set(0x1p1000) ? V::set(0x1p-100) : (large < V::set(0x1p-900) ? V::set(0x1p200) : V::set(1.0));
  small = small * scale;
  large = large * scale;
  // atan(t) = pi / 4 + atan((t - 1) / (t + 1)) keeps |r| below tan(pi / 8).
  const auto turned = small > large * 0.41421356237309503;
  const D r = (turned ? small - large : small) / (turned ? small + large : large);
  const D z = r * r;
  D sum = V::set(0.021259853041374648389);
  sum = sum * z - 0.043590960689364359747;
  sum = sum * z + 0.056925393114080000979;
  sum = sum * z - 0.066411212591859809478;
  sum = sum * z + 0.076900683088481778084;
  sum = sum * z - 0.090907824130680211688;
  sum = sum * z + 0.11111106653612671953;
  sum = sum * z - 0.14285714195261893414;
  sum = sum * z + 0.19999999999088961715;
  sum = sum * z - 0.33333333333330150769;
  const D tail = r * z * sum;  // atan(r) = r + tail
  // The angle is one of 0, 1/4, 1/2, 3/4, 1 times pi, plus or minus atan(r).
  const auto left = x < zero;
  const D base_hi = steep ? V::set(pi_hi / 2) : (left ? V::set(pi_hi) : zero);
  const D base_lo = steep ? V::set(pi_lo / 2) : (left ? V::set(pi_lo) : zero);
  const D sign = steep ? (left ? V::set(1.0) : V::set(-1.0)) : (left ? V::set(-1.0) : V::set(1.0));
  // Multiples of pi_hi / 4 are exact except for three of them.
  D hi = base_hi + (turned ? sign * (pi_hi / 4) : zero);
  D lo = base_lo + (turned ? sign * (pi_lo / 4) : zero);
  hi = left ? (turned ? V::set(three_quarters_hi) : hi) : hi;
  lo = left ? (turned ? V::set(three_quarters_lo) : lo) : lo;
  const D part = sign * r;
  // hi + part is rounded; its rounding error joins the small terms. |hi| >= |part| or hi = 0.
  const D top = hi + part;
  const D angle = top + ((part - (top - hi)) + (lo + sign * tail));
  const D result = y < zero ? -angle : angle;
  return x == x ? (y == y ? result : y) : x;  // NaN
}

// Rational approximations of erf and erfc by Cody, Mathematics of Computation 23, 1969, in y = |x| / sqrt(2): of erf up
// to erf_end, of erfc from there to erfc_near_end, and to erfc_far_end, above which it is 0.
constexpr double log2_e = 1.4426950408889634, sqrt_half = 0.70710678118654752;
constexpr double one_over_sqrt_pi = 0.56418958354775629, density_at_0 = 0.39894228040143268;
constexpr double erf_end = 0.46875, erfc_near_end = 4.0, erfc_far_end = 26.5;
constexpr double erf_numerator[] = {1.85777706184603153e-1, 3.16112374387056560e0, 1.13864154151050156e2,
                                    3.77485237685302021e2, 3.20937758913846947e3};
constexpr double erf_denominator[] = {1.0, 2.36012909523441209e1, 2.44024637934444173e2, 1.28261652607737228e3,
                                      2.84423683343917062e3};
constexpr double erfc_near_numerator[] = {2.15311535474403846e-8, 5.64188496988670089e-1, 8.88314979438837594e0,
                                          6.61191906371416295e1,  2.98635138197400131e2,  8.81952221241769090e2,
                                          1.71204761263407058e3,  2.05107837782607147e3,  1.23033935479799725e3};
constexpr double erfc_near_denominator[] = {1.0,
                                            1.57449261107098347e1,
                                            1.17693950891312499e2,
                                            5.37181101862009858e2,
                                            1.62138957456669019e3,
                                            3.29079923573345963e3,
                                            4.36261909014324716e3,
                                            3.43936767414372164e3,
                                            1.23033935480374942e3};
constexpr double erfc_far_numerator[] = {1.63153871373020978e-2, 3.05326634961232344e-1, 3.60344899949804439e-1,
                                         1.25781726111229246e-1, 1.60837851487422766e-2, 6.58749161529837803e-4};
constexpr double erfc_far_denominator[] = {1.0,
                                           2.56852019228982242e0,
                                           1.87295284992346047e0,
                                           5.27905102951428412e-1,
                                           6.05183413124413191e-2,
                                           2.33520497626869185e-3};

/// Returns the largest whole number up to x, |x| < 2^51.
template <class D>
[[gnu::always_inline]] inline D floor_lanes(D x) {
  const D nearest = (x + 0x1.8p52) - 0x1.8p52;
  return nearest > x ? nearest - 1.0 : nearest;
}

template <class V, class D = typename V::D>
[[gnu::always_inline]] inline D exp_lanes(D x) {
  const D k = floor_lanes(x * log2_e + 0.5);
  const D r = (x - k * ln2_hi) - k * ln2_lo;
  D sum = V::set(1.0 / 6227020800);  // 1 / 13!
  sum = sum * r + 1.0 / 479001600;
  sum = sum * r + 1.0 / 39916800;
  sum = sum * r + 1.0 / 3628800;
  sum = sum * r + 1.0 / 362880;
  sum = sum * r + 1.0 / 40320;
  sum = sum * r + 1.0 / 5040;
  sum = sum * r + 1.0 / 720;
  sum = sum * r + 1.0 / 120;
  sum = sum * r + 1.0 / 24;
  sum = sum * r + 1.0 / 6;
  sum = sum * r + 0.5;
  // k + 1023 at the lower end of a double that is larger by 2^52.
  const D power_of_2 = V::from_bits(V::bits(k + (0x1p52 + 1023.0)) << 52);
  const D zero = V::set(0.0), infinity = V::set(__builtin_inf());
  const D beyond = x < zero ? zero : (x > zero ? infinity : x);  // NaN stays one
  return V::abs(x) <= V::set(700.0) ? (1.0 + (r + r * r * sum)) * power_of_2 : beyond;
}

template <class V, std::size_t count, class D = typename V::D>
[[gnu::always_inline]] inline D ratio_lanes(const double (&numerator)[count], const double (&denominator)[count], D x) {
  D above = V::set(numerator[0]), below = V::set(denominator[0]);
#pragma GCC unroll 9
  for (std::size_t i = 1; i < count; ++i) {
    above = V::fma(above, x, V::set(numerator[i]));
    below = V::fma(below, x, V::set(denominator[i]));
  }
  return above / below;
}

/// Returns exp(-x^2), x >= 0: the square's upper part is exact.
template <class V, class D = typename V::D>
[[gnu::always_inline]] inline D gauss_lanes(D x) {
  const D high = floor_lanes(x * 16.0) / 16.0;
  return exp_lanes<V>(-high * high) * exp_lanes<V>(-(x - high) * (x + high));
}

template <class V, class D = typename V::D>
[[gnu::always_inline]] inline D normal_density_lanes(D x) {
  return density_at_0 * exp_lanes<V>(-0.5 * x * x);
}

template <class V, class D = typename V::D>
[[gnu::always_inline]] inline D normal_distribution_lanes(D x) {
  const D y = V::abs(x) * sqrt_half;
  D result = 0.5 + 0.5 * (x * sqrt_half) * ratio_lanes<V>(erf_numerator, erf_denominator, y * y);
  if (!V::all_within(y, erf_end)) {
    const D bell = gauss_lanes<V>(y);
    D tail = bell * ratio_lanes<V>(erfc_near_numerator, erfc_near_denominator, y);
    if (!V::all_within(y, erfc_near_end)) {
      const D z = 1.0 / (y * y);
      const D far = bell / y * (one_over_sqrt_pi - z * ratio_lanes<V>(erfc_far_numerator, erfc_far_denominator, z));
      tail = y <= V::set(erfc_near_end) ? tail : (y < V::set(erfc_far_end) ? far : V::set(0.0));
    }
    const D outer = x < V::set(0.0) ? 0.5 * tail : 1.0 - 0.5 * tail;
    result = y <= V::set(erf_end) ? result : outer;
  }
  return x == x ? result : x;  // NaN
}

/// Coefficients of x^0 .. x^7.
using Octic = double[8];
template <class V, class D = typename V::D>
[[gnu::always_inline]] inline D polynomial(const Octic& c, D x) {
  D sum = V::set(c[7]);
#pragma GCC unroll 8
  for (int i = 6; i >= 0; --i) sum = sum * x + c[i];
  return sum;
}
template <class V, class D = typename V::D>
[[gnu::always_inline]] inline D rational(const Octic& numerator, const Octic& denominator, D x) {
  return polynomial<V>(numerator, x) / polynomial<V>(denominator, x);
}

// |p - 1/2| <= 0.425, in 0.425^2 - (p - 1/2)^2.
constexpr Octic center_numerator{3.3871328727963666080e0,  1.3314166789178437745e+2, 1.9715909503065514427e+3,
                                 1.3731693765509461125e+4, 4.5921953931549871457e+4, 6.7265770927008700853e+4,
                                 3.3430575583588128105e+4, 2.5090809287301226727e+3};
constexpr Octic center_denominator{1.0,
                                   4.2313330701600911252e+1,
                                   6.8718700749205790830e+2,
                                   5.3941960214247511077e+3,
                                   2.1213794301586595867e+4,
                                   3.9307895800092710610e+4,
                                   2.8729085735721942674e+4,
                                   5.2264952788528545610e+3};
// r = sqrt(-log p) <= 5, in r - 1.6.
constexpr Octic near_numerator{1.42343711074968357734e0,  4.63033784615654529590e0, 5.76949722146069140550e0,
                               3.64784832476320460504e0,  1.27045825245236838258e0, 2.41780725177450611770e-1,
                               2.27238449892691845833e-2, 7.74545014278341407640e-4};
constexpr Octic near_denominator{1.0,
                                 2.05319162663775882187e0,
                                 1.67638483018380384940e0,
                                 6.89767334985100004550e-1,
                                 1.48103976427480074590e-1,
                                 1.51986665636164571966e-2,
                                 5.47593808499534494600e-4,
                                 1.05075007164441684324e-9};
// r > 5, in r - 5.
constexpr Octic far_numerator{6.65790464350110377720e0,  5.46378491116411436990e0,  1.78482653991729133580e0,
                              2.96560571828504891230e-1, 2.65321895265761230930e-2, 1.24266094738807843860e-3,
                              2.71155556874348757815e-5, 2.01033439929228813265e-7};
constexpr Octic far_denominator{1.0,
                                5.99832206555887937690e-1,
                                1.36929880922735805310e-1,
                                1.48753612908506148525e-2,
                                7.86869131145613259100e-4,
                                1.84631831751005468180e-5,
                                1.42151175831644588870e-7,
                                2.04426310338993978564e-15};

/// The inverse normal distribution: in its middle, |p - 1/2| <= central_half, and in its tails. Each function's result
/// is meaningless outside of its own part.
constexpr double central_half = 0.425;
template <class V, class D = typename V::D>
[[gnu::always_inline]] inline D central_normal_lanes(D p) {
  const D q = p - 0.5;
  return q * rational<V>(center_numerator, center_denominator, 0.180625 - q * q);
}
template <class V, class D = typename V::D>
[[gnu::always_inline]] inline D tail_normal_lanes(D p) {
  const D q = p - 0.5, zero = V::set(0.0);
  const D r = V::sqrt(-log_lanes<V>(q < zero ? p : 1.0 - p));
  D z = rational<V>(near_numerator, near_denominator, r - 1.6);
  if (!V::all_within(r, 5.0)) {
    z = r <= V::set(5.0) ? z : rational<V>(far_numerator, far_denominator, r - 5.0);
  }
  return q < zero ? -z : z;
}

/// Returns the middle of one of 2^52 equal cells of (0, 1), so that neither 0 nor 1 occurs and 1 - u is exact: (k +
/// 1/2) / 2^52, k the upper 52 bits.
template <class V>
[[gnu::always_inline]] inline typename V::D to_unit_interval(typename V::I bits) {
  const auto fraction = (bits >> 12) & V::set_bits(0x000fffffffffffff);
  return (V::from_bits(fraction | V::set_bits(0x3ff0000000000000)) - 1.0) + 0x1p-53;
}

/// Computes Philox4x32-10 (Salmon et al., SC 2011) with four 32-bit words in each 64-bit lane's lower half.
template <class V>
struct PhiloxWords {
  typename V::I word[4];
};
template <class V>
[[gnu::always_inline]] inline PhiloxWords<V> philox_lanes(PhiloxWords<V> counter, std::uint32_t key0,
                                                          std::uint32_t key1) {
  const auto low = V::set_bits(0xffffffff);
  for (int round = 0; round < 10; ++round) {
    const auto product0 = V::multiply_low(counter.word[0], V::set_bits(0xD2511F53));
    const auto product1 = V::multiply_low(counter.word[2], V::set_bits(0xCD9E8D57));
    counter = {{((product1 >> 32) & low) ^ counter.word[1] ^ V::set_bits(key0), product1 & low,
                ((product0 >> 32) & low) ^ counter.word[3] ^ V::set_bits(key1), product0 & low}};
    key0 += 0x9E3779B9U;  // golden ratio
    key1 += 0xBB67AE85U;  // sqrt(3) - 1
  }
  return counter;
}

}  // namespace
}  // namespace decid
