// Elementary functions with promised bits: see math.hpp.
// Reductions: log, exp and log1p as in fdlibm (Sun, 1993); atan from the nearest eighth; Taylor polynomials throughout.
// Pairs (hi, lo) below are a constant's nearest double and the double nearest to what is left.
#include "base/math.hpp"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace decid {
namespace {

constexpr double pi_hi = 0x1.921fb54442d18p+1, pi_lo = 0x1.1a62633145c07p-53;
constexpr double sqrt_2 = 1.4142135623730951;
constexpr double log2_e = 1.4426950408889634;
// ln2_hi ends in 21 zero bits: its product with an exponent is exact.
constexpr double ln2_hi = 6.93147180369123816490e-01, ln2_lo = 1.90821492927058770002e-10;

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

struct Pair {
  double hi, lo;
};
constexpr Pair atan_of_eighths[9] = {
    {0.0, 0.0},
    {0x1.fd5ba9aac2f6ep-4, -0x1.cd37686760c17p-59},
    {0x1.f5b75f92c80ddp-3, 0x1.8ab6e3cf7afbdp-57},
    {0x1.6f61941e4def1p-2, -0x1.c63aae6f6e918p-56},
    {0x1.dac670561bb4fp-2, 0x1.a2b7f222f65e2p-56},
    {0x1.1e00babdefeb4p-1, -0x1.928df287a668fp-58},
    {0x1.4978fa3269ee1p-1, 0x1.2419a87f2a458p-56},
    {0x1.700a7c5784634p-1, -0x1.8c34d25aadef6p-56},
    {0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55},
};

// atan(a / b), 0 <= a <= b, b > 0 and far from the ends of the range: atan(t) = atan(c) + atan((t - c) / (1 + t c)).
Pair atan_of_ratio(double a, double b) {
  const int eighths = static_cast<int>(a / b * 8.0 + 0.5);
  const double c = eighths / 8.0;
  const double r = std::fma(-c, b, a) / std::fma(c, a, b);  // |r| <= 1/16
  const double z = r * r;
  double sum = 1.0 / 13;
  sum = std::fma(sum, z, -1.0 / 11);
  sum = std::fma(sum, z, 1.0 / 9);
  sum = std::fma(sum, z, -1.0 / 7);
  sum = std::fma(sum, z, 1.0 / 5);
  sum = std::fma(sum, z, -1.0 / 3);
  const Pair table = atan_of_eighths[eighths];
  return {table.hi, table.lo + std::fma(r * z, sum, r)};
}

// log(1 + x) for x >= 0.
double log1p(double x) {
  const double u = 1.0 + x;
  // log(1 + x) = log(u) + log((1 + x) / u), and (1 + x) / u differs from 1 by u's rounding error only.
  const double lost = x < 1.0 ? x - (u - 1.0) : 1.0 - (u - x);
  return log(u) + lost / u;
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

double log(double x) noexcept {
  const auto bits = std::bit_cast<std::uint64_t>(x);
  double exponent = static_cast<double>(static_cast<int>(bits >> 52) - 1023);
  double mantissa = std::bit_cast<double>((bits & 0x000fffffffffffffu) | 0x3ff0000000000000u);
  if (mantissa > sqrt_2) {
    mantissa *= 0.5;
    exponent += 1.0;
  }
  // log(1 + f) = 2 atanh(s), s = f / (2 + f), written as f - (f^2 / 2 - s (f^2 / 2 + R)): the large parts are exact.
  const double f = mantissa - 1.0;
  const double s = f / (2.0 + f);
  const double z = s * s;
  double r = 2.0 / 21;
  r = r * z + 2.0 / 19;
  r = r * z + 2.0 / 17;
  r = r * z + 2.0 / 15;
  r = r * z + 2.0 / 13;
  r = r * z + 2.0 / 11;
  r = r * z + 2.0 / 9;
  r = r * z + 2.0 / 7;
  r = r * z + 2.0 / 5;
  r = r * z + 2.0 / 3;
  r *= z;
  const double half_square = 0.5 * f * f;
  return exponent * ln2_hi - ((half_square - (s * (half_square + r) + exponent * ln2_lo)) - f);
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
  if (std::isnan(x) || std::isnan(y)) return std::numeric_limits<double>::quiet_NaN();
  const double width = std::abs(x), height = std::abs(y);
  const bool steep = height > width;
  double small = steep ? width : height, large = steep ? height : width;
  if (large == 0.0) return 0.0;
  if (std::isinf(large)) {
    small = std::isinf(small) ? 1.0 : 0.0;
    large = 1.0;
  }
  // Powers of two, so exact; sums of the two can neither overflow nor lose bits to underflow.
  const double scale = large > 0x1p1000 ? 0x1p-100 : large < 0x1p-900 ? 0x1p200 : 1.0;
  const Pair atan = atan_of_ratio(small * scale, large * scale);

  double angle;
  if (!steep) {
    angle = x < 0.0 ? (pi_hi - atan.hi) + (pi_lo - atan.lo) : atan.hi + atan.lo;
  } else {
    angle = x < 0.0 ? (pi_hi / 2 + atan.hi) + (pi_lo / 2 + atan.lo) : (pi_hi / 2 - atan.hi) + (pi_lo / 2 - atan.lo);
  }
  return y < 0.0 ? -angle : angle;
}

double asinh(double x) noexcept {
  const double a = std::abs(x);
  if (!(a <= std::numeric_limits<double>::max())) return x;
  // Above 2^28, x^2 + 1 = x^2.
  const double value = a > 0x1p28 ? log(a) + (ln2_hi + ln2_lo) : log1p(a + a * a / (1.0 + std::sqrt(a * a + 1.0)));
  return x < 0.0 ? -value : value;
}

}  // namespace decid
