// Tests of base/math/statistics.hpp: figures computed by hand or published, ties, even counts and constants.
#include "base/math/statistics.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "tests/near.hpp"

using namespace decid;
using decid::test::near;
using decid::test::within;

TEST_CASE("statistics: means, standard deviations and variances of known values") {
  const std::vector<double> values{1.0, 2.0, 4.0, 9.0};  // about their mean: -3, -2, 0, 5
  CHECK(mean(values) == 4.0);
  CHECK(mean(std::vector<float>{1.0F, 2.0F, 4.0F, 9.0F}) == 4.0);
  CHECK(near(stddev(values), std::sqrt(38.0 / 4.0), 1e-15));
  CHECK(near(sample_variance(values), 38.0 / 3.0, 1e-15));
  CHECK(std::isnan(mean(std::vector<double>{})));
}

TEST_CASE("statistics: medians and quantiles, of values in any order") {
  CHECK(median({9.0, 1.0, 4.0}) == 4.0);
  CHECK(median({9.0, 1.0, 4.0, 2.0}) == 4.0);  // the upper of the two in the middle
  const std::vector<double> values{4.0, 9.0, 1.0, 2.0};
  CHECK(quantile(values, 0.0) == 1.0);
  CHECK(quantile(values, 1.0) == 9.0);
  CHECK(quantile(values, 0.5) == 3.0);
  CHECK(near(quantile(values, 0.75), 4.0 + 0.25 * 5.0, 1e-15));
  CHECK(quantile_of_sorted(std::vector<double>{7.0}, 0.3) == 7.0);
}

TEST_CASE("statistics: correlations from -1 to 1, and 0 of a constant") {
  const std::vector<double> a{1.0, 2.0, 3.0, 4.0}, reversed{4.0, 3.0, 2.0, 1.0}, even{1.0, -1.0, -1.0, 1.0};
  CHECK(near(correlation(a, a), 1.0, 1e-15));
  CHECK(near(correlation(a, reversed), -1.0, 1e-15));
  CHECK(correlation(a, even) == 0.0);
  CHECK(correlation(a, std::vector<double>(4, 2.0)) == 0.0);
}

TEST_CASE("statistics: Hedges' g of a published example, and its factor beside the exact one") {
  // Borenstein et al., Introduction to Meta-Analysis, 2009, page 27.
  CHECK(within(hedges_g(3.0, 5.0249, 98.0), 0.5924, 0.00005));
  CHECK(hedges_g(-3.0, 5.0249, 98.0) == -hedges_g(3.0, 5.0249, 98.0));
  // gamma(f / 2) / (sqrt(f / 2) gamma((f - 1) / 2)), from which J differs by 0.007 at f = 2.
  CHECK(within(hedges_g(1.0, 1.0, 2.0), 0.5641895835477563, 0.0073));
  CHECK(within(hedges_g(1.0, 1.0, 10.0), 0.9227456080530874, 0.0004));
  CHECK(within(hedges_g(1.0, 1.0, 20.0), 0.9619445337407485, 0.0004));
  CHECK(std::isnan(hedges_g(1.0, 0.0, 10.0)));
  CHECK(std::isnan(hedges_g(1.0, 1.0, 1.5)));
}
