// Tests of the mechanics of sim/double_pendulum.hpp: against the Lagrangian, and the conservation of energy.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "sim/double_pendulum.hpp"
#include "tests/near.hpp"
#include "tests/sim/double_constants.hpp"

using namespace decid::sim;
using namespace decid::test;

namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

/// Returns kinetic plus potential energy in J; 0 at rest, upright.
double energy_of(const Constants& c, const DoubleState& s) {
  const double kinetic = 0.5 * c.a1 * s.leg_rate * s.leg_rate + 0.5 * c.a2 * s.trunk_rate * s.trunk_rate +
                         c.b * std::cos(s.leg_rad - s.trunk_rad) * s.leg_rate * s.trunk_rate;
  return kinetic + c.g1 * (std::cos(s.leg_rad) - 1.0) + c.g2 * (std::cos(s.trunk_rad) - 1.0);
}

}  // namespace

TEST_CASE("DoubleBody: accelerations and energy are those of the Lagrangian") {
  struct Row {
    double leg, trunk, leg_rate, trunk_rate, ankle, hip, leg_acceleration, trunk_acceleration, energy;
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
    // 1 - cos loses eps to its difference.
    CHECK(std::abs(energy_of(c, state) - row.energy) < 10.0 * eps * (c.g1 + c.g2 + std::abs(row.energy)));
  }
}

TEST_CASE("DoubleBody: energy is conserved to the order of the integrator") {
  const Segments segments = make_segments({});
  const DoubleBody body(segments);
  const Constants c(segments);
  // Springs at both joints, without damping, hold it.
  const double ankle_spring = 2.0 * make_body(segments).mgh(), hip_spring = 2.0 * segments.trunk_mgh();
  const auto energy = [&](const DoubleState& s) {
    const double bend = s.trunk_rad - s.leg_rad;
    return energy_of(c, s) + 0.5 * ankle_spring * s.leg_rad * s.leg_rad + 0.5 * hip_spring * bend * bend;
  };
  const auto worst = [&](double step_s) {
    DoubleState state{0.1, -0.25, 0.2, 0.4};
    const double first = energy(state);
    double error = 0.0;
    for (int k = 0; k < static_cast<int>(std::lround(5.0 / step_s)); ++k) {
      body.step(state, -ankle_spring * state.leg_rad, -hip_spring * (state.trunk_rad - state.leg_rad), step_s);
      error = std::max(error, std::abs(energy(state) - first));
      REQUIRE(std::abs(state.trunk_rad) < segment_limit_rad);
    }
    return error / first;
  };
  const double coarse = worst(1e-3), fine = worst(5e-4), finest = worst(2.5e-4);
  // Semi-implicit Euler keeps E - step/2 v.F of a linear system, and |v.F| is at most omega E: the energy moves within
  // omega step of its first value, 10.5 rad/s of the faster mode times 1 ms. Twice that for what is not linear at 0.25
  // rad.
  CHECK(coarse < 2.0 * 10.5e-3);
  // First order: halved with the step, to the second order's part of about omega step.
  CHECK(near(coarse / fine, 2.0, 0.02));
  CHECK(near(fine / finest, 2.0, 0.01));
}
