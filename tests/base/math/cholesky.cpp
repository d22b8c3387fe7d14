// Cholesky factors and their inverses against the products that define them.
#include "base/math/cholesky.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "tests/base/math/positive_definite.hpp"
#include "tests/near.hpp"

using namespace decid;
using decid::test::positive_definite, decid::test::within;

TEST_CASE("factorize: L L^t is the matrix; invert_lower: L times its inverse is 1") {
  for (const std::size_t size : {1U, 2U, 7U, 40U}) {
    const std::vector<double> matrix = positive_definite(size);
    std::vector<double> lower = matrix;
    REQUIRE(factorize(size, lower));
    std::vector<double> inverse = lower;
    invert_lower(size, inverse);
    double worst = 0.0, worst_inverse = 0.0, largest = 0.0;
    for (std::size_t i = 0; i < size; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        double product = 0.0, one = 0.0;
        for (std::size_t k = 0; k <= j; ++k) product += lower[triangle(i) + k] * lower[triangle(j) + k];
        for (std::size_t k = j; k <= i; ++k) one += lower[triangle(i) + k] * inverse[triangle(k) + j];
        worst = std::max(worst, std::abs(product - matrix[triangle(i) + j]));
        worst_inverse = std::max(worst_inverse, std::abs(one - (i == j ? 1.0 : 0.0)));
        largest = std::max(largest, matrix[triangle(i) + j]);
      }
    }
    const double bound = static_cast<double>(size + 1) * std::numeric_limits<double>::epsilon();
    CHECK(within(worst, 0.0, bound * largest));
    CHECK(within(worst_inverse, 0.0, 100.0 * bound));  // the condition number of L is below 100
  }
}

TEST_CASE("solve_lower, solve_upper: L times the solution is the right side") {
  constexpr std::size_t size = 7;
  std::vector<double> lower = positive_definite(size);
  REQUIRE(factorize(size, lower));
  std::vector<double> right(size), y;
  for (std::size_t i = 0; i < size; ++i) right[i] = static_cast<double>(i) - 2.5;
  y = right;
  solve_lower(size, lower, y);
  for (std::size_t i = 0; i < size; ++i) {
    double sum = 0.0;
    for (std::size_t k = 0; k <= i; ++k) sum += lower[triangle(i) + k] * y[k];
    CHECK(within(sum, right[i], 1e-14 * static_cast<double>(size)));
  }
  y = right;
  solve_upper(size, lower, y);
  for (std::size_t i = 0; i < size; ++i) {
    double sum = 0.0;
    for (std::size_t k = i; k < size; ++k) sum += lower[triangle(k) + i] * y[k];
    CHECK(within(sum, right[i], 1e-14 * static_cast<double>(size)));
  }
}

TEST_CASE("factorize: matrices that are not positive definite or not finite are refused") {
  std::vector<double> indefinite{1.0, 2.0, 1.0};
  CHECK_FALSE(factorize(2, indefinite));
  std::vector<double> negative{-1.0};
  CHECK_FALSE(factorize(1, negative));
  std::vector<double> not_a_number{1.0, std::nan(""), 1.0};
  CHECK_FALSE(factorize(2, not_a_number));
}
