// Comparison of models against sums by hand, and against the maximum of the stacked density on a grid.
#include "posterior/sampling/model_comparison.hpp"

#include <cmath>

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

TEST_CASE("compare_models: other numbers of observations are refused") {
  check_error([] { compare_models({}); }, decid::Code::size_mismatch);
  check_error([] { compare_models(std::vector<std::vector<double>>{{-1.0}}); }, decid::Code::size_mismatch);
  check_error(
      [] {
        compare_models(std::vector<std::vector<double>>{{-1.0, -2.0}, {-1.0, -2.0, -3.0}});
      },
      decid::Code::size_mismatch);
}
