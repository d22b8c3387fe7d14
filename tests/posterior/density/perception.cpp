// The noise that a body perceives, and the tilt that it estimates, against sums of the basis and the simulator's steps.
#include <algorithm>

#include "posterior/density/density.hpp"
#include "tests/helpers.hpp"
#include "tests/posterior/density/density_points.hpp"
#include "tests/posterior/trial.hpp"

using namespace decid;
using namespace decid::posterior;
using namespace decid::test;

TEST_CASE("Density: the perceived tilt is the noise plus the part of noise and platform that passes the dead band") {
  const sim::Protocol protocol = sines_protocol();
  const Density density(protocol, {});
  const Values x = random_points(density, 5);
  const auto size = static_cast<std::size_t>(density.edges()) * lanes;
  CHECK(density.edges() == 201);
  CHECK(near(density.bin_s(), 0.1, 1e-15));
  CHECK(near(density.block_s(), 0.1, 1e-15));
  Values noise(size), tilt(size), none(size - 1);
  Density::Workspace work(density);
  density.perceive(x, noise, tilt, work);
  CHECK_THROWS_AS(density.perceive(x, noise, none, work), Error);
  CHECK_THROWS_AS(density.perceive(x, none, tilt, work), Error);
  CHECK_THROWS_AS(density.perceive(none, noise, tilt, work), Error);

  // 10 s of standing before the trial: 100 bins.
  constexpr std::size_t lead = 100;
  const int bins = protocol.experiment.steps() / 100 + 8;
  const NoiseBasis basis(protocol, 100, static_cast<int>(lead) + bins, bins, 4.4);
  REQUIRE(basis.size() == density.noise_size());
  const sim::Stimulus stimulus = sim::make_stimulus(protocol.experiment);
  std::vector<double> column(static_cast<std::size_t>(basis.edges()));
  for (std::size_t l = 0; l < lanes; l += 5) {
    const sim::Parameters parameters = density.state(x, static_cast<int>(l)).parameters;
    const double nv = parameters[sim::Nv], theta = parameters[sim::Theta];
    std::vector<double> expected(column.size(), 0.0);
    for (int i = 0; i < basis.size(); ++i) {
      basis.column(i, column);
      const double factor = nv / std::sqrt(nv * nv + 0.05 * 0.05) * x[static_cast<std::size_t>(i) * lanes + l];
      for (std::size_t edge = 0; edge < column.size(); ++edge) expected[edge] += factor * column[edge];
    }
    expected.erase(expected.begin(), expected.begin() + lead - 1);  // edge + 1 is the trial's
    // Half-way between edges the cubic through four of them.
    const auto middle = [&](std::size_t edge) {
      const double near = expected[edge + 1] + expected[edge + 2];
      return (9.0 * near - expected[edge] - expected[edge + 3]) / 16.0;
    };
    // Step by step, as the simulator integrates; halves of bins take velocities for straight lines.
    double estimate = 0.0, largest = 0.0, worst = 0.0;
    for (std::size_t edge = 0; edge < static_cast<std::size_t>(density.edges()); ++edge) {
      CHECK(within(noise[edge * lanes + l], expected[edge + 1], 1e-12));
      worst = std::max(worst, std::abs(tilt[edge * lanes + l] - estimate));
      largest = std::max(largest, std::abs(estimate));
      for (int j = 0; j < 100 && edge + 1 < static_cast<std::size_t>(density.edges()); ++j) {
        const double between = (j % 50 + 0.5) / 50.0;
        const double low = j < 50 ? expected[edge + 1] : middle(edge);
        const double high = j < 50 ? middle(edge) : expected[edge + 2];
        const double velocity =
            stimulus.rate_at(static_cast<int>(edge) * 100 + j) + (1.0 - between) * low + between * high;
        estimate += sim::integration_step_s * (velocity - std::clamp(velocity, -theta, theta));
      }
    }
    CHECK(largest > 1e-3);
    CHECK(worst < 1e-3 * largest);
  }
}
