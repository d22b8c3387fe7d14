// Student's t distribution: against figures of 40 digits (mpmath's betainc), and its inverse.
#include "identify/network/student_t.hpp"

#include <doctest/doctest.h>

#include "tests/near.hpp"

using decid::student_t_critical;
using decid::student_t_tails;
using decid::test::near;

TEST_CASE("student_t: critical values, by mpmath") {
  CHECK(near(student_t_critical(0.05, 1.0), 12.706204736174705, 1e-13));
  CHECK(near(student_t_critical(0.05, 3.7), 2.8675207071911895, 1e-13));
  CHECK(near(student_t_critical(0.05 / 7.0, 8.0), 3.5843568620301808, 1e-13));
  CHECK(near(student_t_critical(0.05 / 7.0, 57.3), 2.7901167609134566, 1e-13));
  CHECK(student_t_critical(1.0, 5.0) == 0.0);
}

TEST_CASE("student_t: the critical value is where the tails have the probability") {
  for (const double probability : {0.9, 0.5, 0.05, 0.05 / 7.0, 1e-5})
    for (const double degrees_of_freedom : {1.0, 1.5, 2.0, 8.0, 57.3, 1000.0, 10'000.0})
      CHECK(near(student_t_tails(student_t_critical(probability, degrees_of_freedom), degrees_of_freedom), probability,
                 1e-11));
}

TEST_CASE("student_t: the Cauchy distribution has one degree of freedom, two have a closed form") {
  CHECK(near(student_t_tails(1.0, 1.0), 0.5, 1e-14));
  CHECK(near(student_t_tails(2.0, 2.0), 1.0 - 2.0 / 2.449489742783178, 1e-13));  // 1 - t / sqrt(2 + t^2)
  CHECK(student_t_tails(0.0, 3.0) == 1.0);
}
