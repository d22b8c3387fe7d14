// The fit recovers what a trial was simulated with, and repeats itself.
#include "tools/compare/fit.hpp"

#include <doctest/doctest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"

namespace decid::iterative {
namespace {

constexpr long long small_budget = 21'000;

std::vector<float> trial(const sim::Simulator& simulator, const sim::Parameters& parameters) {
  std::vector<double> sway(static_cast<std::size_t>(simulator.samples()));
  REQUIRE(simulator.run(parameters, Random(21, sim::streams::vestibular_noise, 0), sway).valid);
  return {sway.begin(), sway.end()};
}

}  // namespace

TEST_CASE("fit: a noise-free trial gives its parameters back, all but the passive stiffness" *
          doctest::test_suite("slow")) {
  const sim::Simulator simulator(sim::short_protocol());
  const sim::Parameters truth =
      sim::single_pendulum().parameters.from_unit(std::vector<double>{0.35, 0.6, 0.65, 0.4, 0.0, 0.3, 0.45});
  const std::vector<float> sway = trial(simulator, truth);
  const std::vector<Start> starts{middle_start(sim::single_pendulum().parameters)};
  const Result result = fit(simulator, sway, starts, {small_budget, 1});
  CHECK(result.stands);
  CHECK(result.simulations <= small_budget);
  CHECK(result.simulations > small_budget / 2);
  const std::vector<double> expected = sim::single_pendulum().parameters.to_unit(truth),
                            found = sim::single_pendulum().parameters.to_unit(result.likeliest);
  // The valley is narrow and the passive stiffness lies along it: other seeds find it up to a third of the range away.
  for (const std::size_t p : {sim::Kp, sim::Kd, sim::Kd_pass, sim::Delay}) {
    CAPTURE(sim::single_pendulum().parameters[p].name);
    CAPTURE(result.cost);
    CHECK(std::abs(found[p] - expected[p]) < 0.1);
  }
  CHECK(found[sim::Nv] < 0.05);

  const int threads = omp_get_max_threads();
  omp_set_num_threads(threads == 1 ? 2 : 1);
  const Result again = fit(simulator, sway, starts, {min_simulations(1), 1});
  omp_set_num_threads(threads);
  const Result same = fit(simulator, sway, starts, {min_simulations(1), 1});
  CHECK(again.parameters == same.parameters);
  CHECK(again.standard_error == same.standard_error);
  CHECK(again.likeliest == same.likeliest);
  CHECK(again.cost == same.cost);
  CHECK(again.simulations == min_simulations(1));
  CHECK(again.cost > result.cost);  // more simulations, a better fit
}

TEST_CASE("fit: priors hold the estimate, and widen its errors") {
  const sim::Simulator simulator(sim::short_protocol());
  const std::vector<float> sway =
      trial(simulator,
            sim::single_pendulum().parameters.from_unit(std::vector<double>{0.35, 0.6, 0.65, 0.4, 0.5, 0.3, 0.45}));
  Start start{sim::single_pendulum().parameters.from_unit(std::vector<double>{0.4, 0.55, 0.3, 0.5, 0.5, 0.8, 0.5}),
              0.08, 0.0};
  const Settings settings{min_simulations(1), 1};
  const std::vector<double> known = sim::single_pendulum().parameters.to_unit(start.parameters);
  const auto farthest = [&](const Result& result) {
    const std::vector<double> found = sim::single_pendulum().parameters.to_unit(result.parameters);
    double distance = 0;
    for (std::size_t p = 0; p < sim::single_pendulum().parameters.size(); ++p)
      distance = std::max(distance, std::abs(found[p] - known[p]));
    return distance;
  };
  const Result free = fit(simulator, sway, std::vector{start}, settings);
  start.prior = 0.01;
  const Result held = fit(simulator, sway, std::vector{start}, settings);
  CHECK(farthest(held) < 0.04);  // four deviations
  CHECK(farthest(free) > 2 * farthest(held));
  for (std::size_t p = 0; p < sim::single_pendulum().parameters.size(); ++p) {
    const double range = sim::single_pendulum().parameters[p].high - sim::single_pendulum().parameters[p].low;
    CAPTURE(sim::single_pendulum().parameters[p].name);
    CHECK(held.standard_error[p] > 0.005 * range);
    CHECK(held.standard_error[p] < 0.1 * range);
  }
}

TEST_CASE("fit: a prior of a hundredth of the range that agrees with the recording keeps its width") {
  const sim::Simulator simulator(sim::short_protocol());
  const sim::Parameters truth =
      sim::single_pendulum().parameters.from_unit(std::vector<double>{0.4, 0.55, 0.3, 0.5, 0.5, 0.8, 0.5});
  const Start start{truth, 0.1, 0.01};
  const Result result = fit(simulator, trial(simulator, truth), std::vector{start}, {small_budget, 1});
  // A trial says little within a hundredth of a range, so the draws have the prior's sd, which counts 2.5 times. With n
  // effective draws each sd has an error of 1 / sqrt(2 n); the mean of seven has a bit more than a third of it.
  REQUIRE(result.effective_samples > 20);
  double ratio = 0;
  for (std::size_t p = 0; p < sim::single_pendulum().parameters.size(); ++p) {
    const double range = sim::single_pendulum().parameters[p].high - sim::single_pendulum().parameters[p].low;
    ratio +=
        result.standard_error[p] / (2.5 * 0.01 * range) / static_cast<double>(sim::single_pendulum().parameters.size());
    CHECK(test::within(result.parameters[p], truth[p], 3.5 * 0.01 * range));
  }
  CHECK(test::within(ratio, 1.0, 4 / std::sqrt(14 * result.effective_samples)));
}

TEST_CASE("fit: random starts lie within the ranges, another one per number and seed") {
  const sim::ParameterTable& table = sim::single_pendulum().parameters;
  const sim::Parameters first = random_start(table, 1, 0).parameters;
  for (const double u : table.to_unit(first)) CHECK((u > 0.0 && u < 1.0));
  CHECK(first != random_start(table, 1, 1).parameters);
  CHECK(first != random_start(table, 2, 0).parameters);
}

TEST_CASE("fit: invalid requests") {
  const sim::Simulator simulator(sim::default_protocol());
  const std::vector<float> sway(static_cast<std::size_t>(simulator.samples()));
  const std::vector<Start> starts{middle_start(sim::single_pendulum().parameters)};
  CHECK_THROWS_AS(fit(simulator, sway, {}, {}), Error);
  CHECK_THROWS_AS(fit(simulator, sway, starts, {min_simulations(1) - 1, 1}), Error);
  CHECK_THROWS_AS(fit(simulator, std::span(sway).subspan(1), starts, {}), Error);
  test::check_error(
      [&] {
        fit(simulator, sway, std::vector<Start>{starts.front(), Start{}}, {});
      },
      Code::size_mismatch, "0 parameters");
}

}  // namespace decid::iterative
