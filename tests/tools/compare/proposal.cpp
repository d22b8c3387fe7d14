// Proposals of the fit's rounds.
#include "tools/compare/proposal.hpp"

#include <vector>

#include "tests/helpers.hpp"
#include "tools/compare/cmaes.hpp"

namespace decid::iterative {
namespace {

/// Weighted points about 0.4 in n dimensions, neighbours correlated.
std::vector<Point> some_points(int n) {
  const Random random(3, iterative::search_stream, 1);
  std::vector<Point> points;
  for (std::uint64_t i = 0; i < 60; ++i) {
    Vector unit(n);
    for (int d = 0; d < n; ++d) {
      const std::uint64_t at = i * 100 + static_cast<std::uint64_t>(d);
      unit[d] = 0.4 + 0.05 * random.normal(at) + 0.02 * random.normal(at + 1);
    }
    points.push_back({unit, 0.0});
  }
  return points;
}

std::vector<double> some_weights() {
  std::vector<double> weights;
  for (int i = 0; i < 60; ++i) weights.push_back(1.0 / (1.0 + i % 7));
  return weights;
}

}  // namespace

TEST_CASE("draws in fourteen dimensions lie in the box and have the moments that were asked for, wider") {
  constexpr int n = 14, count = 4000;
  constexpr double wider = 1.5;
  const Moments wanted = moments(some_points(n), some_weights());
  const Proposal proposal(wanted, wider);
  const Random random(5, iterative::search_stream, 3);
  std::uint64_t next = 0;
  std::vector<Point> drawn;
  double energy = 0.0;
  for (int i = 0; i < count; ++i) {
    drawn.push_back({proposal.draw(random, next), 0.0});
    CHECK(drawn.back().unit.minCoeff() >= 0.0);
    CHECK(drawn.back().unit.maxCoeff() <= 1.0);
    energy += proposal.energy(drawn.back().unit) / count;
  }
  const Moments found = moments(drawn, std::vector<double>(drawn.size(), 1.0));
  // Five deviations; 0.4 is five deviations from the box's edge, which cuts off next to nothing.
  for (int d = 0; d < n; ++d) {
    const double variance = wider * wanted.covariance(d, d) + 1e-6;
    CHECK(test::within(found.mean[d], wanted.mean[d], 5.0 * std::sqrt(variance / count)));
    CHECK(test::near(found.covariance(d, d), variance, 5.0 * std::sqrt(2.0 / count)));
  }
  CHECK(test::near(energy, 0.5 * n, 5.0 * std::sqrt(2.0 / (n * count))));
}

}  // namespace decid::iterative
