// The information of a density against products of differences, whitened by an explicit covariance matrix; its factors.
#include <array>
#include <numeric>

#include "base/math/cholesky.hpp"
#include "posterior/density/density.hpp"
#include "tests/helpers.hpp"
#include "tests/posterior/density/density_points.hpp"
#include "tests/posterior/trial.hpp"

using namespace decid;
using namespace decid::posterior;
using namespace decid::test;

TEST_CASE("Density: the information is that of the model's derivatives and of the prior") {
  const sim::Protocol protocol = sines_protocol();
  const Density density(protocol, {});
  const Observation observation = density.observe(recorded(protocol, some_parameters(), 0.02, 0));
  const Values x = random_points(density, 2);
  Density::Workspace work(density);
  const auto size = static_cast<std::size_t>(density.size());
  std::vector<double> information(triangle(size) * lanes);
  density.information(observation, x, information, work);
  const int noises = density.noise_size();
  const std::vector<int> some{0,          1,          11,         noises - 1, noises,     noises + 1, noises + 2,
                              noises + 3, noises + 4, noises + 5, noises + 6, noises + 8, noises + 9};
  CHECK(worst_information(density, observation, x, some) < 4e-4);
  const double step = 1e-5;
  const std::size_t kept = coefficients(density);
  // For a coefficient of variance P, two noise levels have half the product of the derivatives of log P.
  const std::array<int, 3> levels{7, 10, 11};  // measurement noise, slow noise and its memory
  for (std::size_t l = 0; l < lanes; ++l) {
    std::array<std::vector<double>, 3> changes;
    for (std::size_t a = 0; a < levels.size(); ++a) {
      Values high = x, low = x;
      at(high, noises + levels[a], l) += step;
      at(low, noises + levels[a], l) -= step;
      const DenseNoise above = noise_of(density, density.state(high, static_cast<int>(l))),
                       below = noise_of(density, density.state(low, static_cast<int>(l)));
      for (std::size_t k = 0; k < kept; ++k) {
        const double offset = k == 0 ? 100.0 * sim::rad_per_deg * sim::rad_per_deg * density.blocks() : 0.0;
        changes[a].push_back(std::log((offset + above.power(k)) / (offset + below.power(k))) / (2.0 * step));
      }
    }
    for (std::size_t a = 0; a < levels.size(); ++a) {
      for (std::size_t b = 0; b <= a; ++b) {
        const double expected = 0.5 * std::inner_product(changes[a].begin(), changes[a].end(), changes[b].begin(), 0.0);
        const std::size_t entry =
            triangle(static_cast<std::size_t>(noises + levels[a])) + static_cast<std::size_t>(noises + levels[b]);
        CHECK(
            within(information[entry * lanes + l], expected + (a == b ? 1.0 : 0.0), 1e-7 * (1.0 + std::abs(expected))));
      }
    }
  }
  std::vector<double> factor;
  for (std::size_t i = 0; i < triangle(size); ++i) factor.push_back(information[i * lanes + 1]);
  const std::vector<double> matrix = factor;
  CHECK(factorize(size, factor));

  // The same, and what follows from it, chain by chain in lanes.
  const Kernels& run = kernels(density.isa());
  AlignedVector<double> lane_factors(information.begin(), information.end());
  run.factorize(density.size(), lane_factors.data());
  double worst = 0.0;
  for (std::size_t i = 0; i < triangle(size); ++i)
    worst = std::max(worst, std::abs(lane_factors[i * lanes + 1] - factor[i]) / std::abs(factor[triangle(size) - 1]));
  CHECK(worst < 1e-8);
  Values ones(size * lanes, 1.0), solution(size * lanes, 1.0), product(size * lanes, 0.0);
  run.solve_transposed(density.size(), lane_factors.data(), solution.data());
  for (std::size_t column = 0; column < size; ++column) {
    double sum = 0.0;
    for (std::size_t row = column; row < size; ++row)
      sum += lane_factors[(triangle(row) + column) * lanes + 1] * at(solution, static_cast<int>(row), 1);
    REQUIRE(near(sum, 1.0, 1e-8));
  }
  run.symmetric_times(density.size(), information.data(), ones.data(), product.data());
  for (std::size_t row = 0; row < size; ++row) {
    double sum = 0.0, scale = 0.0;
    for (std::size_t column = 0; column < size; ++column) {
      const double value = matrix[triangle(std::max(row, column)) + std::min(row, column)];
      sum += value;
      scale += std::abs(value);
    }
    REQUIRE(within(at(product, static_cast<int>(row), 1), sum, 1e-12 * scale));
  }
}
