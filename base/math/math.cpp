// Elementary functions with reproducible bits: see math.hpp. math_lanes.hpp has the functions that vector lanes need
// too. Reduction of exp as in fdlibm (Sun, 1993); Taylor polynomials. Pairs (hi, lo) are a constant's nearest double
// and the double nearest to the remainder.
#include "base/math/math.hpp"

#include <cmath>

#include "base/math/math_lanes.hpp"

namespace decid {
namespace {

// A processor's fused multiply-add replaces the call of fma(), with the same bits. The choice happens at program start,
// before sanitizers are ready. clang before 18 makes no such choice, or one that other compilers do not find.
#if defined(__x86_64__) && defined(__GLIBC__) && !defined(DECID_SANITIZED) && \
    (!defined(__clang__) || __clang_major__ >= 18)
#define DECID_WITH_FMA [[gnu::target_clones("default", "fma")]]
#else
#define DECID_WITH_FMA
#endif

// Returns sin and cos of hi + lo, |hi| <= pi / 4, |lo| below half a unit in hi's last place.
[[gnu::always_inline]] inline SinCos sincos_octant(double hi, double lo) {
  const double z = hi * hi;
  double s = 1.0 / 355687428096000;  // 1 / 17!
  s = std::fma(s, z, -1.0 / 1307674368000);
  s = std::fma(s, z, 1.0 / 6227020800);
  s = std::fma(s, z, -1.0 / 39916800);
  s = std::fma(s, z, 1.0 / 362880);
  s = std::fma(s, z, -1.0 / 5040);
  s = std::fma(s, z, 1.0 / 120);
  s = std::fma(s, z, -1.0 / 6);
  double c = 1.0 / 20922789888000;  // 1 / 16!
  c = std::fma(c, z, -1.0 / 87178291200);
  c = std::fma(c, z, 1.0 / 479001600);
  c = std::fma(c, z, -1.0 / 3628800);
  c = std::fma(c, z, 1.0 / 40320);
  c = std::fma(c, z, -1.0 / 720);
  c = std::fma(c, z, 1.0 / 24);
  // 1 - z / 2 is rounded; its rounding error joins the small terms.
  const double half = 0.5 * z;
  const double top = 1.0 - half;
  const double cos = top + (((1.0 - top) - half) + std::fma(z * z, c, -hi * lo));
  const double sin = hi + std::fma(hi * z, s, lo * cos);
  return {sin, cos};
}

}  // namespace

DECID_WITH_FMA SinCos sincos_of_turn(long long n, long long d) noexcept {
  // The angle is a / (8 d) turns; it is mirrored into the first octant, a <= d.
  long long a = n % d;
  if (a < 0) a += d;
  a *= 8;
  const bool lower = a > 4 * d;
  if (lower) a = 8 * d - a;
  const bool left = a > 2 * d;
  if (left) a = 4 * d - a;
  const bool steep = a > d;
  if (steep) a = 2 * d - a;

  // pi / 4 * a / d as hi + lo.
  const auto numerator = static_cast<double>(a), denominator = static_cast<double>(d);
  const double ratio = numerator / denominator;
  const double ratio_lo = std::fma(-ratio, denominator, numerator) / denominator;
  const double hi = ratio * (pi_hi / 4);
  const double lo = std::fma(ratio, pi_hi / 4, -hi) + (ratio_lo * (pi_hi / 4) + ratio * (pi_lo / 4));
  auto [sin, cos] = sincos_octant(hi, lo);
  if (steep) {
    const double swapped = sin;
    sin = cos;
    cos = swapped;
  }
  return {lower ? -sin : sin, left ? -cos : cos};
}

SinCos sincos_of_turns(double turns) noexcept {
  constexpr long long parts = 1LL << 52;
  return sincos_of_turn(static_cast<long long>((turns - std::floor(turns)) * static_cast<double>(parts)), parts);
}

double sin_small(double x) noexcept {
  return sin_small_lanes(x);
}

double cos_small(double x) noexcept {
  return cos_small_lanes(x);
}

double log(double x) noexcept {
  return log_lanes<One>(x);
}

double exp(double x) noexcept {
  return exp_lanes<One>(x);
}

double atan2(double y, double x) noexcept {
  return atan2_lanes<One>(y, x);
}

double asinh(double x) noexcept {
  return asinh_lanes<One>(x);
}

double normal_density(double x) noexcept {
  return normal_density_lanes<One>(x);
}

double normal_distribution(double x) noexcept {
  return normal_distribution_lanes<One>(x);
}

}  // namespace decid
