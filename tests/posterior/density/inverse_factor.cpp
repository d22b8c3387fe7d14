// The kernels' inverse of a Cholesky factor against the plain functions.
#include <doctest/doctest.h>

#include "base/aligned.hpp"
#include "posterior/kernels/kernels.hpp"
#include "tests/base/math/positive_definite.hpp"

using namespace decid;
using namespace decid::posterior;
using decid::test::positive_definite;

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
