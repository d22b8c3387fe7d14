// Cholesky factors and their inverses against the products that define them.
#include "posterior/cholesky.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "base/aligned.hpp"
#include "base/math/random.hpp"
#include "posterior/kernels/kernels.hpp"
#include "posterior/streams.hpp"
#include "tests/near.hpp"

using namespace decid;
using namespace decid::posterior;
using decid::test::within;

namespace {

/// A A^t of random rows, and 1 on the diagonal: positive definite.
std::vector<double> positive_definite(std::size_t size) {
  std::vector<double> rows(size * size), matrix(triangle(size));
  Random(4, posterior::streams::chains, size).fill_normal(rows);
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = i == j ? 1.0 : 0.0;
      for (std::size_t k = 0; k < size; ++k) sum += rows[i * size + k] * rows[j * size + k];
      matrix[triangle(i) + j] = sum;
    }
  }
  return matrix;
}

}  // namespace

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

TEST_CASE("inverse_factor: the bits of factorize and invert_lower, for every instruction set") {
  for (const std::size_t size : {1U, 7U, 8U, 9U, 40U, 67U}) {
    const std::vector<double> matrix = positive_definite(size);
    std::vector<double> expected = matrix;
    REQUIRE(factorize(size, expected));
    invert_lower(size, expected);
    for (const Isa isa : available_isas()) {
      std::vector<double> found = matrix;
      AlignedVector<double> work(inverse_work(size));
      CHECK(kernels(isa).inverse_factor(static_cast<int>(size), found.data(), work.data()));
      CHECK(found == expected);
      std::vector<double> indefinite = matrix;
      indefinite.back() = -1.0;
      CHECK_FALSE(kernels(isa).inverse_factor(static_cast<int>(size), indefinite.data(), work.data()));
    }
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
