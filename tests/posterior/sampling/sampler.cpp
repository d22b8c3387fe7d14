// The sampler on densities whose moments are known.
#include "posterior/sampling/sampler.hpp"

#include <cmath>
#include <vector>

#include "base/math/cholesky.hpp"
#include "tests/helpers.hpp"
#include "tests/posterior/sampling/prior_draws.hpp"
#include "tests/posterior/trial.hpp"

using namespace decid;
using namespace decid::posterior;
using namespace decid::test;

namespace {

/// A recording that says nothing: the sensor's noise is fixed far above any sway, so the posterior is the prior.
struct Prior {
  sim::Protocol protocol = sines_protocol();
  Density density{protocol, {}};
  std::size_t globals = static_cast<std::size_t>(density.globals());
  Observation observation = density.observe(recorded(protocol, some_parameters(), 0.02, 0));
};

}  // namespace

TEST_CASE_FIXTURE(Prior, "Sampler: where the recording says nothing, transitions keep the prior") {
  Sampler sampler(Target(density, observation), 3, 0);
  sampler.fix_noise(1e6);
  double noise_squares = 0.0, accepted = 0.0;
  const auto noises = static_cast<std::size_t>(density.noise_size());
  const int draws = check_prior_is_kept(sampler, {}, 0, noises, globals, [&] {
    for (int chain = 0; chain < lanes; ++chain) {
      const auto l = static_cast<std::size_t>(chain);
      accepted += sampler.acceptance()[l];
      const double nv = density.state(sampler.coordinates(), chain).parameters[sim::Nv];
      // Noise coefficient 5 over its deviation given Nv.
      const double w = sampler.coordinates()[5 * lanes + l] / std::sqrt(nv * nv + 0.05 * 0.05);
      noise_squares += w * w;
    }
  });
  CHECK(within(noise_squares / draws, 1.0, 0.11));
  CHECK(accepted / draws > 0.6);
}

TEST_CASE_FIXTURE(Prior,
                  "Sampler: small steps keep the energy, so all is accepted; huge steps diverge and change the "
                  "white noise alone") {
  Sampler sampler(Target(density, observation), 3, 1);
  for (int chain = 0; chain < lanes; ++chain)
    density.set({.parameters = some_parameters(), .sensor_noise_deg = 0.02}, sampler.coordinates(), chain);
  const std::vector<double> before(sampler.coordinates().begin(), sampler.coordinates().end());
  sampler.begin_adapting(2.0);
  sampler.move(3);
  for (std::size_t l = 0; l < lanes; ++l) {
    CHECK(sampler.diverged()[l]);
    CHECK(sampler.acceptance()[l] == 0.0);
  }
  const auto white = static_cast<std::size_t>(density.noise_size()) + density.place(Density::sensor_noise);
  for (std::size_t i = 0; i < before.size(); ++i)
    CHECK((sampler.coordinates()[i] == before[i]) == (i / lanes != white));
  sampler.begin_adapting(1e-6);
  sampler.move(3);
  for (std::size_t l = 0; l < lanes; ++l) CHECK(sampler.acceptance()[l] > 0.999);
  CHECK(!std::equal(before.begin(), before.end(), sampler.coordinates().begin()));
  CHECK(sampler.leapfrog_steps() == 8);
}

// Far from where the noise is probable, one step of this length loses at least a tenth of the energy, 8,000.
TEST_CASE("Sampler: a large gain of a transition is accepted on the way, and is a divergence while chains draw") {
  const sim::Protocol protocol = sines_protocol();
  Priors priors;
  priors.parameters.push_back({.name = "Nv", .fixed = 0.3});
  const Density density(protocol, priors);
  const Observation observation = density.observe(recorded(protocol, some_parameters(), 0.02, 0));
  const auto noises = static_cast<std::size_t>(density.noise_size());
  const double scale = std::sqrt(0.3 * 0.3 + 0.05 * 0.05);  // of a noise coefficient
  for (const bool holds : {false, true}) {
    Sampler sampler(Target(density, observation), 3, 0);
    sampler.fix_noise(1e6);
    sampler.hold_last(holds);
    const double far = scale * std::sqrt(16'000.0 / static_cast<double>(noises));
    std::fill_n(sampler.coordinates().begin(), noises * lanes, far);
    sampler.begin_adapting(scale);
    sampler.move(1);
    for (std::size_t l = 0; l < lanes; ++l) {
      CHECK(sampler.diverged()[l] == holds);
      CHECK(sampler.acceptance()[l] == (holds ? 0.0 : 1.0));
      CHECK((sampler.coordinates()[l] == far) == holds);
    }
  }
}

TEST_CASE_FIXTURE(Prior, "Sampler: a metric that is not positive definite is refused and changes nothing") {
  Sampler sampler(Target(density, observation), 3, 0);
  const auto size = static_cast<std::size_t>(density.size());
  CHECK_FALSE(sampler.set_metric(std::vector(1, std::vector<double>(triangle(size), 0.0))));
  std::vector<double> matrices(triangle(size) * lanes), information(triangle(size));
  sampler.information(sampler.coordinates(), matrices);
  for (std::size_t i = 0; i < information.size(); ++i) information[i] = matrices[i * lanes];
  CHECK(sampler.set_metric(std::vector(1, information)));
}

TEST_CASE_FIXTURE(Prior, "Sampler: globals that are held stay where they are, and all others move") {
  Sampler sampler(Target(density, observation), 3, 0);
  for (int chain = 0; chain < lanes; ++chain)
    density.set({.parameters = some_parameters(), .sensor_noise_deg = 0.02, .slow_noise_deg = 0.01},
                sampler.coordinates(), chain);
  const auto size = static_cast<std::size_t>(density.size()), moving = size - Density::held;
  const auto check = [&] {
    const std::vector<double> before(sampler.coordinates().begin(), sampler.coordinates().end());
    sampler.begin_adapting(1e-6);
    sampler.move(3);
    for (std::size_t i = 0; i < size * lanes; ++i) {
      REQUIRE(sampler.acceptance()[i % lanes] > 0.9);
      REQUIRE((sampler.coordinates()[i] == before[i]) == (i >= moving * lanes));
    }
  };
  sampler.hold_last(true);
  check();
  std::vector<double> matrices(triangle(size) * lanes), information(triangle(size));
  sampler.information(sampler.coordinates(), matrices);
  for (std::size_t i = 0; i < information.size(); ++i) information[i] = matrices[i * lanes];
  REQUIRE(sampler.set_metric(std::vector(1, information)));
  check();
}

TEST_CASE_FIXTURE(Prior, "Sampler: the potential is the density's") {
  Sampler sampler(Target(density, observation), 3, 0);
  Density::Workspace work(density);
  std::vector<double> gradient(sampler.coordinates().size()), potential(lanes);
  density.evaluate(observation, sampler.coordinates(), gradient, potential, work);
  const Sampler::Lanes found = sampler.potential(sampler.coordinates());
  for (std::size_t l = 0; l < lanes; ++l) CHECK(found[l] == potential[l]);
}

// Points whose deviation is 1 in units of the metric, except in one direction, where it is 5.
TEST_CASE_FIXTURE(Prior, "Sampler: the widest direction is found in units of the metric") {
  Sampler sampler(Target(density, observation), 3, 0);
  const auto size = static_cast<std::size_t>(density.size()), noises = static_cast<std::size_t>(density.noise_size());
  std::vector<double> metric(triangle(size), 0.0);
  for (std::size_t i = 0; i < size; ++i) metric[triangle(i) + i] = i < noises ? 7.0 : 4.0;
  metric[triangle(noises + 2) + noises + 1] = 1.0;
  REQUIRE(sampler.set_metric(std::vector(1, metric)));
  std::vector<std::vector<double>> points;
  const double root = std::sqrt(0.5);
  for (std::size_t i = 0; i < globals; ++i) {
    for (const double sign : {-1.0, 1.0}) {
      // Eigenvectors of the metric's block: (1, 1) and (1, -1) over root 2 with values 5 and 3, unit vectors with 4.
      std::vector<double>& point = points.emplace_back(globals, 0.0);
      const double length = sign * std::sqrt(static_cast<double>(globals)) * (i == 1 ? 5.0 : 1.0);
      if (i == 1 || i == 2) {
        point[1] = length * root / std::sqrt(i == 1 ? 5.0 : 3.0);
        point[2] = (i == 1 ? 1.0 : -1.0) * point[1];
      } else {
        point[i] = length / 2.0;
      }
    }
  }
  CHECK(near(sampler.widest(points), 5.0, 1e-9));
  CHECK(sampler.widest(std::vector(4, points[0])) == 0.0);
}
