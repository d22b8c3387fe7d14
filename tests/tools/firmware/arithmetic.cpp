// The arithmetic that exported C files carry for targets without fused multiply-adds or libm, beside the host's.
#include <doctest/doctest.h>

#include <bit>
#include <cfloat>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

#include "base/math/math.hpp"
#include "base/math/random.hpp"

// As for a target that has no such instruction, whatever this machine has.
#undef __FP_FAST_FMA
#undef __FP_FAST_FMAF
#undef __FMA__
#define USES_FMA_FLOAT 1
#define USES_FMA_DOUBLE 1
#define USES_IS_FINITE 1
#define USES_FLOAT_BITS 1
#define USES_SQUARE_ROOT 1
#define USES_LOG 1
#define USES_ASINH 1
#define USES_PHASE 1
namespace {
#include "tools/firmware/runtime/arithmetic.c"
// Other files of the firmware.
#include "tools/firmware/runtime/angle.c"
#include "tools/firmware/runtime/elementary.c"
}  // namespace
static_assert(HAS_FMA_FLOAT == 0 && HAS_FMA_DOUBLE == 0);

namespace decid {
namespace {

template <class Real>
bool same(Real a, Real b) {
  return std::memcmp(&a, &b, sizeof a) == 0 || (a != a && b != b);
}

/// Doubles of every kind: any bits, or exponents so close that sums cancel, or few bits, or special ones.
double some_double(const Random& random, std::uint64_t k) {
  static constexpr double special[] = {0.0,
                                       -0.0,
                                       1.0,
                                       -1.0,
                                       DBL_MAX,
                                       -DBL_MAX,
                                       DBL_MIN,
                                       5e-324,
                                       -5e-324,
                                       DBL_EPSILON,
                                       std::numeric_limits<double>::infinity(),
                                       -std::numeric_limits<double>::infinity(),
                                       std::numeric_limits<double>::quiet_NaN()};
  const std::uint64_t bits = random.bits(2 * k), kind = random.bits(2 * k + 1);
  const auto near_one = std::bit_cast<double>((bits & 0x800fffffffffffffU) | ((1020 + kind / 8 % 7) << 52));
  switch (kind % 8) {
    case 0:
    case 1:
      return std::bit_cast<double>(bits);
    case 2:
      return special[kind / 8 % std::size(special)];
    case 3:
      return std::bit_cast<double>(bits & 0x801fffffffffffffU);  // subnormal, or nearly
    case 4:
      return std::bit_cast<double>(std::bit_cast<std::uint64_t>(near_one) & 0xfffffffffc000000U);
    default:
      return near_one;
  }
}

}  // namespace

TEST_CASE("exported files: a b + c with integers is exactly rounded") {
  const Random random(17, Stream::weights, 0);
  int wrong = 0;
  const auto check = [&](double a, double b, double c) {
    if (same(fma_double(a, b, c), std::fma(a, b, c))) return;
    if (++wrong < 5) MESSAGE(a << " " << b << " " << c << ": " << fma_double(a, b, c) << ", not " << std::fma(a, b, c));
  };
  for (std::uint64_t k = 0; k < 300'000; ++k) {
    const double a = some_double(random, 3 * k), b = some_double(random, 3 * k + 1);
    check(a, b, some_double(random, 3 * k + 2));
    check(a, b, -(a * b));  // what the product's rounding lost
    check(a, b, -(a * b) * (1.0 + DBL_EPSILON));
  }
  CHECK(wrong == 0);
}

TEST_CASE("exported files: a b + c in float by way of double is exactly rounded") {
  const Random random(18, Stream::weights, 0);
  int wrong = 0;
  for (std::uint64_t k = 0; k < 300'000; ++k) {
    const auto some = [&](std::uint64_t i) {
      const std::uint64_t bits = random.bits(3 * k + i);
      const auto any = std::bit_cast<float>(static_cast<std::uint32_t>(bits));
      const auto near_one = std::bit_cast<float>((static_cast<std::uint32_t>(bits) & 0x807fffffU) |
                                                 static_cast<std::uint32_t>((120 + bits / (1ULL << 40) % 14) << 23));
      return (bits >> 60) < 4 ? any : near_one;
    };
    const float a = some(0), b = some(1), c = some(2);
    for (const float term : {c, -(a * b)}) wrong += same(fma_float(a, b, term), std::fma(a, b, term)) ? 0 : 1;
  }
  CHECK(wrong == 0);
}

TEST_CASE("exported files: bits distinguish numbers and floats from infinities and NaN") {
  const Random random(21, Stream::weights, 0);
  int wrong = 0;
  for (std::uint64_t k = 0; k < 100'000; ++k) {
    const double x = some_double(random, k);
    wrong += (is_finite(x) != 0) == std::isfinite(x) ? 0 : 1;
  }
  CHECK(wrong == 0);
  for (const float value : {0.0F, -1.0F, FLT_MAX, -FLT_MAX, FLT_MIN, 1e-45F}) CHECK(is_finite_float(value) == 1);
  const float infinity = std::numeric_limits<float>::infinity();
  for (const float value : {infinity, -infinity, std::numeric_limits<float>::quiet_NaN()})
    CHECK(is_finite_float(value) == 0);
}

TEST_CASE("exported files: the integer square root is exactly rounded") {
  const Random random(19, Stream::weights, 0);
  int wrong = 0;
  for (std::uint64_t k = 0; k < 300'000; ++k) {
    const double x = std::abs(some_double(random, k));
    wrong += same(square_root(x), std::sqrt(x)) ? 0 : 1;
    wrong += same(square_root(x * x), std::sqrt(x * x)) ? 0 : 1;
  }
  CHECK(wrong == 0);
}

TEST_CASE("exported files: subnormal numbers that are flushed are noticed") {
  CHECK(keeps_subnormals() == 1);
#if defined(__SSE2__)
  const unsigned mode = _mm_getcsr();
  for (const unsigned flushes : {0x8000U, 0x0040U, 0x8040U}) {  // where they arise, where they are read
    _mm_setcsr(mode | flushes);
    const std::int32_t kept = keeps_subnormals();
    _mm_setcsr(mode);
    CAPTURE(flushes);
    CHECK(kept == 0);
  }
#endif
}

TEST_CASE("exported files: elementary functions have the library's bits") {
  const Random random(20, Stream::weights, 0);
  int wrong = 0;
  for (std::uint64_t k = 0; k < 300'000; ++k) {
    double x = some_double(random, 2 * k), y = some_double(random, 2 * k + 1);
    wrong += same(inverse_sinh(x), asinh(x)) ? 0 : 1;
    const double positive = std::abs(x);
    if (std::isnormal(positive)) wrong += same(natural_log(positive), log(positive)) ? 0 : 1;
    // The image's bins: finite, and no -0 among them.
    if (!std::isfinite(x) || !std::isfinite(y)) continue;
    x = x + 0.0;
    y = y + 0.0;
    wrong += same(angle_of(y, x), atan2(y, x)) ? 0 : 1;
  }
  CHECK(wrong == 0);
}

}  // namespace decid
