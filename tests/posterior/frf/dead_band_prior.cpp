#include "posterior/frf/dead_band_prior.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "posterior/frf/response.hpp"
#include "sim/body_model.hpp"
#include "tests/near.hpp"

using namespace decid;
using namespace decid::test;

namespace {

const sim::ParameterTable& ranges() {
  return sim::single_pendulum().parameters;
}

/// The velocity of the default tilt, and about the noise's velocity at Nv = 1.
double passes(double nv, double theta) {
  return frf::mean_passed(0.0041, 0.0155 * nv, theta) / 0.0041;
}

posterior::Quantile uniform(std::size_t parameter) {
  return {.low = ranges()[parameter].low, .range = ranges()[parameter].range()};
}

frf::DeadBandPrior uniform_prior() {
  return {uniform(sim::Nv), uniform(sim::Theta), passes};
}

}  // namespace

TEST_CASE("uniform ranks are uniform Nv and theta") {
  const frf::DeadBandPrior prior = uniform_prior();
  constexpr int side = 300;
  std::vector<double> nv, theta, products;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      const auto point = prior.at((i + 0.5) / side, (j + 0.5) / side);
      nv.push_back(point.nv / ranges()[sim::Nv].high);
      theta.push_back(point.theta / ranges()[sim::Theta].high);
    }
  }
  double both = 0.0;
  for (std::size_t i = 0; i < nv.size(); ++i) both += (nv[i] - 0.5) * (theta[i] - 0.5);
  CHECK(within(both / static_cast<double>(nv.size()), 0.0, 2e-4));  // uncorrelated, of 1/12 at most
  for (auto* values : {&nv, &theta}) {
    std::sort(values->begin(), values->end());
    double distance = 0.0;
    for (std::size_t i = 0; i < values->size(); ++i)
      distance = std::max(distance, std::abs((*values)[i] - (static_cast<double>(i) + 0.5) / (side * side)));
    CHECK(distance < 0.004);  // a cell is 0.002
  }
}

TEST_CASE("the passed fraction depends only on its rank") {
  const frf::DeadBandPrior prior = uniform_prior();
  double before = 0.0;
  for (double rank = 0.05; rank < 1.0; rank += 0.05) {
    CAPTURE(rank);
    double least = 1.0, most = 0.0;
    for (double other = 0.01; other < 1.0; other += 0.02) {
      const auto point = prior.at(rank, other);
      least = std::min(least, passes(point.nv, point.theta));
      most = std::max(most, passes(point.nv, point.theta));
    }
    CHECK(most - least < 3e-3);
    CHECK(least > before);
    before = most;
    const double slope = prior.at(rank, 0.5).by_rank;
    const auto low = prior.at(rank - 0.01, 0.5), high = prior.at(rank + 0.01, 0.5);
    CHECK(near(slope, (passes(high.nv, high.theta) - passes(low.nv, low.theta)) / 0.02, 0.25));
  }
}

TEST_CASE("ranks at their ends stay in the ranges") {
  const frf::DeadBandPrior prior = uniform_prior();
  for (const double first : {0.0, 1.0}) {
    for (const double second : {0.0, 1.0}) {
      const auto point = prior.at(first, second);
      CHECK(point.nv >= 0.0);
      CHECK(point.nv <= 1.0);
      CHECK(point.theta >= 0.0);
      CHECK(point.theta <= ranges()[sim::Theta].high);
    }
  }
}

TEST_CASE("a prior's values and slopes at probabilities") {
  const posterior::Quantile flat{.low = 2.0, .range = 3.0};
  CHECK(flat.value_at(0.25) == 2.75);
  CHECK(flat.slope_at(0.25) == 3.0);
  const posterior::Quantile normal = posterior::make_quantile(
      {.parameters = {{"Kp", {}, posterior::ParameterPrior::Normal{900.0, 50.0}, {}}}}, "Kp", 500.0, 800.0);
  CHECK(near(normal.value_at(0.5), 900.0, 1e-9));
  CHECK(near(normal.value_at(0.8413447460685429), 950.0, 1e-9));
  CHECK(near(normal.slope_at(0.8), (normal.value_at(0.8001) - normal.value_at(0.7999)) / 0.0002, 1e-5));
  CHECK(normal.value_at(0.0) >= 500.0);
  CHECK(normal.value_at(1.0) <= 1300.0);
}
