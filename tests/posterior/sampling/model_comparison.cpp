// Comparison of models against sums by hand, and against the maximum of the stacked density on a grid.
#include "posterior/sampling/model_comparison.hpp"

#include <cmath>
#include <vector>

#include "base/math/random.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"

using namespace decid::posterior;
using namespace decid::test;

namespace {

double stacked(const std::vector<std::vector<double>>& pointwise, double first) {
  double sum = 0.0;
  for (std::size_t i = 0; i < pointwise[0].size(); ++i)
    sum += std::log(first * std::exp(pointwise[0][i]) + (1.0 - first) * std::exp(pointwise[1][i]));
  return sum;
}

}  // namespace

TEST_CASE("compare_models: differences, their standard errors, weights") {
  const std::vector<std::vector<double>> pointwise{{-1.0, -2.0, -1.5, -0.5}, {-1.2, -1.0, -2.5, -0.9}};
  const std::vector<ComparedModel> found = compare_models(pointwise);
  REQUIRE(found.size() == 2);
  CHECK(near(found[0].log_density, -5.0, 1e-15));
  CHECK(near(found[1].log_density, -5.6, 1e-15));
  CHECK(found[0].difference == 0.0);
  CHECK(found[0].standard_error == 0.0);
  CHECK(near(found[1].difference, -0.6, 1e-12));
  // Differences -0.2, 1, -1, -0.4 about their mean -0.15.
  CHECK(near(found[1].standard_error, std::sqrt(4.0 / 3.0 * (0.0025 + 1.3225 + 0.7225 + 0.0625)), 1e-12));
  CHECK(near(found[0].weight + found[1].weight, 1.0, 1e-12));
  double best = 0.0, largest = -1e300;
  for (int i = 0; i <= 10'000; ++i) {
    if (const double here = stacked(pointwise, i * 1e-4); here > largest) largest = here, best = i * 1e-4;
  }
  CHECK(within(found[0].weight, best, 2e-4));
}

TEST_CASE("compare_models: a model that predicts everything better has all the weight, equal ones share it") {
  const std::vector<ComparedModel> better =
      compare_models(std::vector<std::vector<double>>{{-3.0, -4.0}, {-1.0, -2.0}});
  CHECK(better[1].weight > 1.0 - 1e-6);
  CHECK(better[0].difference == -4.0);
  CHECK(better[0].standard_error == 0.0);  // the same difference in each observation
  const std::vector<ComparedModel> equal = compare_models(std::vector<std::vector<double>>{{-1.0, -2.0}, {-1.0, -2.0}});
  CHECK(equal[0].weight == 0.5);
}

// The stacked density of nearly equal models is so flat that expectation maximisation would stay at equal weights.
TEST_CASE("compare_models: weights of nearly equal models are those of the maximum") {
  const decid::Random random(7, decid::sim::streams::sensor_noise, 0);
  std::vector<std::vector<double>> pointwise(2, std::vector<double>(1200));
  random.fill_normal(pointwise[0], 1);
  double slope = 0.0;  // of the stacked density by the second model's weight, where it has all
  for (std::size_t i = 0; i < 1200; ++i) {
    const double difference = 0.01 * random.normal(10'000 + i) + 0.001;
    pointwise[1][i] = pointwise[0][i] + difference;
    slope += 1.0 - std::exp(-difference);
  }
  REQUIRE(slope > 0.0);
  CHECK(compare_models(pointwise)[1].weight == 1.0);
  CHECK(compare_models(std::vector{pointwise[1], pointwise[0]})[0].weight == 1.0);
}

TEST_CASE("compare_models: three models share their weights where no change of them gains") {
  const decid::Random random(8, decid::sim::streams::sensor_noise, 0);
  std::vector<std::vector<double>> pointwise(3, std::vector<double>(400));
  for (std::size_t k = 0; k < 3; ++k) random.fill_normal(pointwise[k], 1 + 1000 * k);
  const std::vector<ComparedModel> found = compare_models(pointwise);
  for (std::size_t k = 0; k < 3; ++k) {
    double mean = 0.0;  // of the model's density over the mixture's: 1 for each model with a weight
    for (std::size_t i = 0; i < 400; ++i) {
      double mixed = 0.0;
      for (std::size_t j = 0; j < 3; ++j) mixed += found[j].weight * std::exp(pointwise[j][i]);
      mean += std::exp(pointwise[k][i]) / mixed / 400.0;
    }
    CHECK(found[k].weight > 0.1);
    CHECK(within(mean, 1.0, 1e-6));
  }
}

TEST_CASE("compare_models: other numbers of observations are refused") {
  check_error([] { compare_models({}); }, decid::Code::size_mismatch);
  check_error([] { compare_models(std::vector<std::vector<double>>{{-1.0}}); }, decid::Code::size_mismatch);
  check_error(
      [] {
        compare_models(std::vector<std::vector<double>>{{-1.0, -2.0}, {-1.0, -2.0, -3.0}});
      },
      decid::Code::size_mismatch);
}
