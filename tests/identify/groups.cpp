// Groups compared: against published figures, figures computed with NumPy, and what must hold.
#include "identify/groups.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "tests/near.hpp"

using decid::group_effect;
using decid::group_sample;
using decid::GroupEffect;
using decid::GroupSample;
using decid::test::near;
using decid::test::within;

TEST_CASE("groups: Hedges' g of Borenstein et al. 2009, page 27") {
  const GroupEffect found = group_effect({50, 103.0, 5.5}, {50, 100.0, 4.5});
  CHECK(found.difference == 3.0);
  CHECK(within(found.g, 0.5924, 0.00005));
  // They give the variance, 0.0411.
  const double deviation = (found.high - found.low) / (2.0 * 1.959964);
  CHECK(within(deviation * deviation, 0.0411, 0.00005));
  CHECK(near(found.high + found.low, 2.0 * found.g, 1e-14));
}

TEST_CASE("groups: two small groups, by NumPy") {
  const GroupSample first = group_sample(std::vector<double>{812, 905, 777, 860, 930});
  const GroupSample second = group_sample(std::vector<double>{700, 655, 742, 801});
  CHECK(first.count == 5);
  CHECK(near(first.mean, 856.8, 1e-14));
  CHECK(near(first.deviation, 63.37744078140107, 1e-14));
  CHECK(near(second.deviation, 62.153036933041335, 1e-14));
  const GroupEffect found = group_effect(first, second);
  CHECK(near(found.g, 1.870954512360277, 1e-13));
  CHECK(near(found.low, 0.4173717578651821, 1e-12));
  CHECK(near(found.high, 3.324537266855372, 1e-13));
  const GroupEffect turned = group_effect(second, first);
  CHECK(turned.g == -found.g);
  CHECK(turned.low == -found.high);
}

TEST_CASE("groups: what is unknown is no number") {
  const GroupSample none = group_sample({}), one = group_sample(std::vector<double>{4.0});
  CHECK(std::isnan(none.mean));
  CHECK(one.mean == 4.0);
  CHECK(std::isnan(one.deviation));
  const GroupSample two = group_sample(std::vector<double>{1.0, 3.0}), still = group_sample(std::vector<double>{2, 2});
  CHECK(group_effect(one, two).difference == 2.0);
  CHECK(std::isnan(group_effect(one, two).g));
  CHECK(std::isnan(group_effect(two, none).low));
  CHECK(std::isnan(group_effect(still, still).g));
  CHECK(group_effect(two, still).g == 0.0);
}
