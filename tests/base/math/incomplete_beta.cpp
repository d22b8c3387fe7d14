// The incomplete beta function and Fisher's distribution, against figures of mpmath with 30 digits.
#include "base/math/incomplete_beta.hpp"

#include <doctest/doctest.h>

#include "tests/near.hpp"

using decid::test::near;

TEST_CASE("incomplete beta: tails of Fisher's distribution") {
  CHECK(near(decid::f_tail(3.5, 5.0, 7.25), 0.0637816006439542233, 1e-12));
  CHECK(near(decid::f_tail(0.2, 3.0, 12.0), 0.89437687123425636, 1e-12));
  CHECK(near(decid::f_tail(40.0, 2.0, 9.0), 0.0000332534157843759254, 1e-12));
  CHECK(near(decid::f_tail(1.0, 24.0, 24.0), 0.5, 1e-12));
  CHECK(near(decid::f_critical(0.05, 5.0, 10.0), 3.32583453041301201, 1e-12));
  CHECK(near(decid::f_critical(0.975, 3.5, 20.0), 0.0941680825433941314, 1e-12));
  CHECK(decid::incomplete_beta(2.0, 3.0, 0.0) == 0.0);
  CHECK(decid::incomplete_beta(2.0, 3.0, 1.0) == 1.0);
  CHECK(near(decid::incomplete_beta(2.0, 2.0, 0.25), 0.15625, 1e-13));  // x^2 (3 - 2 x)
  CHECK(near(decid::log_gamma(0.5), 0.57236494292470009, 1e-14));
}
