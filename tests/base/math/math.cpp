// Tests of base/math/math.hpp: every function against the C library's long double version, to the bounds of the header.
// The reference has 11 more bits than a double, so its own error is below 0.001 units in a double's last place.
#include "base/math/math.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "tests/near.hpp"

using decid::test::near;

namespace {

// |value - exact| in units of the last place of a double of that size.
double error_in_ulp(double value, long double exact) {
  int exponent = 0;
  std::frexp(static_cast<double>(exact), &exponent);
  const long double ulp = std::ldexp(1.0L, std::max(exponent, -1021) - 53);
  return static_cast<double>(std::abs(value - exact) / ulp);
}

double relative_error(double value, long double exact) {
  return static_cast<double>(std::abs((value - exact) / exact));
}

// The same numbers everywhere: mt19937_64 is specified to the bit, the standard's distributions are not.
class Arguments {
 public:
  double between(double low, double high) { return low + (high - low) * unit(); }
  double unit() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  /// A positive double, its exponent uniform in [low, high).
  double magnitude(int low, int high) {
    const int exponent = low + static_cast<int>(engine_() % static_cast<unsigned>(high - low));
    return std::ldexp(1.0 + unit(), exponent);
  }
  long long integer(long long bound) {
    return static_cast<long long>(engine_() % static_cast<unsigned long long>(bound));
  }

 private:
  std::mt19937_64 engine_{20240607};
};

constexpr long double pi_long = 3.14159265358979323846264338327950288L;
constexpr double infinity = std::numeric_limits<double>::infinity();

double sincos_error(long long n, long long d) {
  const auto [sin, cos] = decid::sincos_of_turn(n, d);
  const long double angle = 2.0L * pi_long * static_cast<long double>(n % d) / static_cast<long double>(d);
  return static_cast<double>(std::max(std::abs(sin - std::sin(angle)), std::abs(cos - std::cos(angle))));
}

// An emulator has no long double of its own. The tests of bits show there that the values are x86-64's.
#ifdef DECID_EMULATED
constexpr int every = 9;
#else
constexpr int every = 1;
#endif

}  // namespace

TEST_CASE("sincos_of_turn: within its bound") {
  double worst = 0.0;
  for (const long long d : {1, 2, 3, 5, 7, 8, 11, 64, 110, 997, 12100, 121000}) {
    for (long long n = 0; n < d; ++n) worst = std::max(worst, sincos_error(n, d));
  }
  Arguments arguments;
  for (int i = 0; i < 200'000; i += every) {
    const long long d = 1 + arguments.integer(1LL << (1 + i % 52));
    worst = std::max(worst, sincos_error(arguments.integer(d), d));
  }
  CHECK(worst < 2.3e-16);
}

TEST_CASE("sincos_of_turn: symmetries hold to the bit") {
  for (const long long d : {8LL, 24LL, 12100LL * 8, 1LL << 52}) {
    for (long long n = 0; n < 1000; ++n) {
      const auto a = decid::sincos_of_turn(n, d);
      const auto mirrored = decid::sincos_of_turn(-n, d);
      const auto quarter = decid::sincos_of_turn(n + d / 4, d);
      const auto turned = decid::sincos_of_turn(n - 5 * d, d);
      REQUIRE(mirrored.sin == -a.sin);
      REQUIRE(mirrored.cos == a.cos);
      REQUIRE(quarter.sin == a.cos);
      REQUIRE(quarter.cos == -a.sin);
      REQUIRE(turned.sin == a.sin);
      REQUIRE(turned.cos == a.cos);
    }
  }
  const auto eighth = decid::sincos_of_turn(1, 8);
  CHECK(eighth.sin == eighth.cos);
  CHECK(decid::sincos_of_turn(1, 4).cos == 0.0);
  CHECK(decid::sincos_of_turn(1, 2).sin == 0.0);
  CHECK(decid::sincos_of_turn(1, 2).cos == -1.0);
  CHECK(near(decid::sincos_of_turn(1, 12).sin, 0.5, std::numeric_limits<double>::epsilon()));
}

TEST_CASE("sin_small, cos_small: within their bounds") {
  double worst = 0.0;
  const auto test = [&](double x) {
    const auto exact = static_cast<long double>(x);
    if (x != 0.0) worst = std::max(worst, relative_error(decid::sin_small(x), std::sin(exact)));
    worst = std::max(worst, relative_error(decid::cos_small(x), std::cos(exact)));
  };
  for (int i = -500'000; i <= 500'000; i += every) test(i * 1e-6);
  Arguments arguments;
  for (int i = 0; i < 100'000; i += every) test(arguments.magnitude(-300, -1) * (i % 2 == 0 ? 1.0 : -1.0));
  CHECK(worst < 2.5e-16);
  CHECK(decid::sin_small(0.0) == 0.0);
  CHECK(decid::cos_small(0.0) == 1.0);
  CHECK(decid::cos_small(-0.37) == decid::cos_small(0.37));
}

TEST_CASE("log: within its bound") {
  double worst = 0.0;
  const auto test = [&](double x) {
    worst = std::max(worst, error_in_ulp(decid::log(x), std::log(static_cast<long double>(x))));
  };
  for (int i = 1; i <= 400'000; i += every) test(i * 1e-5);
  Arguments arguments;
  for (int i = 0; i < 400'000; i += every) {
    test(arguments.magnitude(-1022, 1024));
    test(1.0 + arguments.magnitude(-52, -2));
    test(1.0 - arguments.magnitude(-53, -2));
  }
  test(std::numeric_limits<double>::min());
  test(std::numeric_limits<double>::max());
  CHECK(worst < 2.0);
  CHECK(decid::log(1.0) == 0.0);
  CHECK(decid::log(2.0) == 0.69314718055994529);
}

TEST_CASE("exp: within its bound") {
  double worst = 0.0;
  const auto test = [&](double x) {
    worst = std::max(worst, relative_error(decid::exp(x), std::exp(static_cast<long double>(x))));
  };
  for (int i = -400'000; i <= 400'000; i += every) test(i * 1e-5);
  Arguments arguments;
  for (int i = 0; i < 400'000; i += every) {
    test(arguments.between(-700.0, 700.0));
    test(arguments.magnitude(-60, 0));
  }
  test(700.0);
  test(-700.0);
  CHECK(worst < 4.5e-16);
  CHECK(decid::exp(0.0) == 1.0);
}

TEST_CASE("exp: beyond its range, and NaN") {
  CHECK(decid::exp(-700.5) == 0.0);
  CHECK(decid::exp(-infinity) == 0.0);
  CHECK(decid::exp(700.5) == infinity);
  CHECK(decid::exp(infinity) == infinity);
  CHECK(std::isnan(decid::exp(std::nan(""))));
}

TEST_CASE("normal_distribution: within its bound") {
  double worst = 0.0, worst_far = 0.0;
  for (int i = -3700; i <= 900; ++i) {
    const double x = i * 0.01 + 0.0037;
    const long double exact = 0.5L * std::erfc(-static_cast<long double>(x) / std::sqrt(2.0L));
    const double error = static_cast<double>(std::abs(decid::normal_distribution(x) / exact - 1.0L));
    double& largest = x > -8.0 ? worst : worst_far;
    largest = std::max(largest, error);
  }
  CHECK(worst < 2e-14);
  CHECK(worst_far < 3e-13);
  CHECK(decid::normal_distribution(0.0) == 0.5);
  CHECK(decid::normal_distribution(40.0) == 1.0);
  CHECK(decid::normal_distribution(-40.0) == 0.0);
  CHECK(decid::normal_distribution(-1e300) == 0.0);
  CHECK(std::isnan(decid::normal_distribution(std::nan(""))));
}

TEST_CASE("atan2: within its bound") {
  double worst = 0.0;
  const auto test = [&](double y, double x) {
    const long double exact = std::atan2(static_cast<long double>(y), static_cast<long double>(x));
    worst = std::max(worst, error_in_ulp(decid::atan2(y, x), exact));
  };
  for (int i = -200; i <= 200; ++i) {
    for (int j = -200; j <= 200; ++j) test(i, j);
  }
  Arguments arguments;
  const auto sign = [&] { return arguments.unit() < 0.5 ? -1.0 : 1.0; };
  for (int i = 0; i < 400'000; i += every) {
    test(sign() * arguments.unit(), sign() * arguments.unit());
    test(sign() * arguments.magnitude(-30, 30), sign() * arguments.magnitude(-30, 30));
    // Both near an end of the range, where products overflow or are lost.
    test(sign() * arguments.magnitude(1015, 1024), sign() * arguments.magnitude(1015, 1024));
    test(sign() * arguments.magnitude(-1040, -1000), sign() * arguments.magnitude(-1040, -1000));
  }
  CHECK(worst < 3.0);
}

TEST_CASE("atan2: special points") {
  constexpr double pi = 3.141592653589793;
  CHECK(decid::atan2(0.0, 0.0) == 0.0);
  CHECK(decid::atan2(0.0, -0.0) == 0.0);
  CHECK(decid::atan2(0.0, 2.0) == 0.0);
  CHECK(decid::atan2(0.0, -2.0) == pi);
  CHECK(decid::atan2(-0.0, -2.0) == pi);  // the range is (-pi, pi]
  CHECK(decid::atan2(2.0, 0.0) == pi / 2);
  CHECK(decid::atan2(-2.0, 0.0) == -pi / 2);
  CHECK(decid::atan2(1.0, 1.0) == pi / 4);
  CHECK(decid::atan2(1e308, 1e-308) == pi / 2);
  CHECK(decid::atan2(1e-308, 1e308) == 0.0);
  CHECK(decid::atan2(infinity, 1.0) == pi / 2);
  CHECK(decid::atan2(1.0, -infinity) == pi);
  CHECK(decid::atan2(-infinity, infinity) == -pi / 4);
  CHECK(std::isnan(decid::atan2(std::nan(""), 1.0)));
  CHECK(std::isnan(decid::atan2(1.0, std::nan(""))));
}

TEST_CASE("asinh: within its bound") {
  double worst = 0.0;
  const auto test = [&](double x) {
    worst = std::max(worst, relative_error(decid::asinh(x), std::asinh(static_cast<long double>(x))));
  };
  for (int i = 1; i <= 400'000; i += every) test(i * 1e-5);
  Arguments arguments;
  for (int i = 0; i < 400'000; i += every) {
    test(arguments.magnitude(-1020, 1024));
    test(-arguments.magnitude(-40, 40));
  }
  CHECK(worst < 1e-15);
  CHECK(decid::asinh(0.0) == 0.0);
  CHECK(decid::asinh(-1.0) == -decid::asinh(1.0));
  CHECK(decid::asinh(infinity) == infinity);
  CHECK(std::isnan(decid::asinh(std::nan(""))));
}
