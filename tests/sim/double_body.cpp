// Tests of the mechanics of sim/double_pendulum.hpp: against the Lagrangian.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "sim/double_pendulum.hpp"
#include "tests/sim/double_constants.hpp"

using namespace decid::sim;
using namespace decid::test;

namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

}  // namespace

TEST_CASE("DoubleBody: accelerations are those of the Lagrangian") {
  struct Row {
    double leg, trunk, leg_rate, trunk_rate, ankle, hip, leg_acceleration, trunk_acceleration;
  };
  const std::vector<Row> rows{
#include "tests/sim/lagrangian.inc"
  };
  const Segments segments = make_segments({.mass_kg = 88.86, .height_m = 1.80});
  const DoubleBody body(segments);
  const Constants c(segments);
  CHECK(rows.size() == 24);
  for (const Row& row : rows) {
    const DoubleState state{row.leg, row.trunk, row.leg_rate, row.trunk_rate};
    const auto found = body.accelerations(state, row.ankle, row.hip);
    // Some ten roundings of the largest terms, multiplied by what the smallest determinant divides them by.
    const double torques = std::abs(row.ankle) + 2.0 * std::abs(row.hip) + c.g1 * std::abs(row.leg) +
                           c.g2 * std::abs(row.trunk) +
                           c.b * (row.leg_rate * row.leg_rate + row.trunk_rate * row.trunk_rate);
    const double bound = 10.0 * eps * torques * c.a1 / (c.a1 * c.a2 - c.b * c.b);
    CHECK(std::abs(found.leg - row.leg_acceleration) < bound);
    CHECK(std::abs(found.trunk - row.trunk_acceleration) < bound);
  }
}
