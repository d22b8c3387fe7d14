// The comparisons that all tests lean on can fail, and say by how much.
#include "tests/near.hpp"

#include <doctest/doctest.h>

#include <limits>
#include <string>

using namespace decid::test;

TEST_CASE("near is relative to the expected value at every scale, within is absolute") {
  for (const double scale : {1e-300, 1e-9, 1.0, -1e9, 1e300}) {
    CHECK(near(1.09 * scale, scale, 0.1));
    CHECK(near(0.91 * scale, scale, 0.1));
    CHECK_FALSE(near(1.11 * scale, scale, 0.1));
    CHECK_FALSE(near(0.89 * scale, scale, 0.1));
    CHECK_FALSE(near(-scale, scale, 1.0));
    CHECK(near(scale, scale, 0));
  }
  CHECK(near(0.0, -0.0, 0.1));
  CHECK_FALSE(near(1e-300, 0, 0.1));

  CHECK(within(1e-3, 0, 1e-3));
  CHECK_FALSE(within(1.1e-3, 0, 1e-3));
  CHECK(within(1000.5, 1000, 0.5));
}

TEST_CASE("a number that is not finite is near to nothing") {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  for (const double odd : {nan, infinity, -infinity})
    for (const double other : {odd, 1.0, 0.0}) {
      CHECK_FALSE(near(odd, other, 1e9));
      CHECK_FALSE(near(other, odd, 1e9));
      CHECK_FALSE(within(odd, other, 1e9));
      CHECK_FALSE(within(other, odd, 1e9));
      CHECK_FALSE(near(other, other, odd));
      CHECK_FALSE(within(other, other, odd));
    }
}

TEST_CASE("a failed comparison shows value, expected value, tolerance and difference") {
  const std::string text = doctest::toString(near(0.5, 0.25, 0.5)).c_str();
  CHECK(text == "0.5, expected 0.25 +- 0.125, differs by 0.25");
}
