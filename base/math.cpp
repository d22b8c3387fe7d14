// Elementary functions with promised bits: see math.hpp.
// Those that are also needed in vector lanes are in math_lanes.hpp. Reduction of exp as in fdlibm (Sun, 1993); Taylor
// polynomials. Pairs (hi, lo) are a constant's nearest double and the double nearest to what is left.
#include "base/math.hpp"

#include <bit>
#include <cmath>
#include <cstdint>

#include "base/math_lanes.hpp"

namespace decid {
namespace {

constexpr double log2_e = 1.4426950408889634;

// sin and cos of hi + lo, |hi| <= pi / 4, |lo| below half a unit in hi's last place.
SinCos sincos_octant(double hi, double lo) {
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
  // 1 - z / 2 is rounded; what it lost is added back with the small terms.
  const double half = 0.5 * z;
  const double top = 1.0 - half;
  const double cos = top + (((1.0 - top) - half) + std::fma(z * z, c, -hi * lo));
  const double sin = hi + std::fma(hi * z, s, lo * cos);
  return {sin, cos};
}

}  // namespace

SinCos sincos_of_turn(long long n, long long d) noexcept {
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
  const double k = std::floor(x * log2_e + 0.5);
  const double r = (x - k * ln2_hi) - k * ln2_lo;  // |r| <= ln 2 / 2, the first difference is exact
  double sum = 1.0 / 6227020800;                   // 1 / 13!
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
  const double power_of_2 = std::bit_cast<double>(static_cast<std::uint64_t>(static_cast<int>(k) + 1023) << 52);
  return (1.0 + (r + r * r * sum)) * power_of_2;
}

double atan2(double y, double x) noexcept {
  return atan2_lanes<One>(y, x);
}

double asinh(double x) noexcept {
  return asinh_lanes<One>(x);
}

}  // namespace decid
