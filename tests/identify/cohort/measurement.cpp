// The evidence of recordings: the moments of draws, priors divided out, weights, refusals.
#include "identify/cohort/measurement.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "base/math/random.hpp"
#include "tests/helpers.hpp"
#include "tests/identify/cohort/made_up.hpp"
#include "tests/near.hpp"

using decid::Code;
using decid::cohort::Measurement;
using namespace decid::test;

namespace {

/// Draws of two correlated coordinates, as fractions.
std::vector<double> fractions(std::size_t draws, double centre, double sd) {
  const decid::Random random(5, decid::Stream::user, 0);
  std::vector<double> values;
  for (std::size_t i = 0; i < draws; ++i) {
    const double one = random.normal(2 * i), other = 0.6 * one + 0.8 * random.normal(2 * i + 1);
    values.push_back(decid::normal_distribution(centre + sd * one));
    values.push_back(decid::normal_distribution(-centre + sd * other));
  }
  return values;
}

/// The mean and the variance of one coordinate of a mixture of draws.
std::array<double, 2> moments(const Measurement& of_draws, std::size_t parameter) {
  double mean = 0.0, square = 0.0;
  for (std::size_t k = 0; k < of_draws.components(); ++k) {
    const std::span<const double> precision = of_draws.precision(k);
    const double determinant = precision[0] * precision[2] - precision[1] * precision[1];
    const double weight = std::exp(of_draws.log_weight(k)) / std::sqrt(determinant);
    const double centre = of_draws.centre(k, parameter);
    mean += weight * centre;
    square += weight * (centre * centre + precision[parameter == 0 ? 2 : 0] / determinant);
  }
  return {mean, square - mean * mean};
}

}  // namespace

TEST_CASE("cohort: draws become a mixture with their mean and variance") {
  const std::vector<double> values = fractions(200, 0.4, 0.3);
  const Measurement measurement = Measurement::of_draws(2, values);
  CHECK(measurement.components() == 1);  // they are Gaussian
  for (std::size_t p = 0; p < 2; ++p) {
    double mean = 0.0, square = 0.0;
    for (std::size_t i = 0; i < 200; ++i) {
      const double x = decid::inverse_normal(values[2 * i + p]);
      mean += x / 200.0;
      square += x * x / 200.0;
    }
    const auto [found, variance] = moments(measurement, p);
    CHECK(near(found, mean, 1e-9));
    const double posterior = (square - mean * mean) * 200.0 / (200.0 - 2.0 - 2.0);  // the mean of inverse covariances
    CHECK(near(variance, posterior, 1e-6));
    CHECK(near(measurement.variance(p), posterior / (1.0 - posterior), 1e-6));
  }
}

TEST_CASE("cohort: draws that depend on each other tell less, and make fewer components") {
  const std::vector<double> values = fractions(200, 0.4, 0.3);
  const Measurement all = Measurement::of_draws(2, values), few = Measurement::of_draws(2, values, {}, 20.0);
  // The same covariance, times 200 / 196 and 20 / 16.
  for (const std::size_t i : {0U, 1U, 2U})
    CHECK(near(all.precision(0)[i] / few.precision(0)[i], (196.0 / 200.0) / (16.0 / 20.0), 1e-9));
  std::vector<double> apart = fractions(400, 0.8, 0.2);
  const std::vector<double> others = fractions(100, -0.8, 0.2);
  apart.insert(apart.end(), others.begin(), others.end());
  CHECK(Measurement::of_draws(2, apart, {}, 12.0).components() == 1);
}

TEST_CASE("cohort: weights take their part of the effective draws") {
  const std::vector<double> values = fractions(200, 0.4, 0.3), half(values.begin(), values.begin() + 200);
  std::vector<double> log_weights(200, 0.0);
  std::fill(log_weights.begin() + 100, log_weights.end(), -60.0);
  const Measurement weighted = Measurement::of_draws(2, values, log_weights, 80.0),
                    same = Measurement::of_draws(2, half, {}, 40.0);
  REQUIRE(weighted.components() == 1);
  for (const std::size_t i : {0U, 1U, 2U}) CHECK(near(weighted.precision(0)[i], same.precision(0)[i], 1e-9));
}

TEST_CASE("cohort: draws in two places become two components") {
  std::vector<double> values = fractions(400, 0.8, 0.2);
  const std::vector<double> others = fractions(100, -0.8, 0.2);
  values.insert(values.end(), others.begin(), others.end());
  const Measurement measurement = Measurement::of_draws(2, values);
  REQUIRE(measurement.components() == 2);
  const std::size_t second = measurement.centre(0, 0) < 0.0 ? 0 : 1;
  CHECK(within(measurement.centre(second, 0), -0.8, 0.08));  // four standard errors
  CHECK(within(measurement.centre(1 - second, 0), 0.8, 0.04));
  CHECK(within(std::exp(measurement.log_weight(second) - measurement.log_weight(1 - second)), 0.25, 0.1));
  const double mean = moments(measurement, 0)[0];
  CHECK(within(mean, 0.8 * 0.6, 0.04));
}

TEST_CASE("cohort: weights take a prior back") {
  // Draws under a prior whose density rises with the first coordinate as exp(2 x): weights exp(-2 x).
  const std::vector<double> values = fractions(256, 0.4, 0.3);
  std::vector<double> log_weights;
  for (std::size_t i = 0; i < 256; ++i) log_weights.push_back(-2.0 * decid::inverse_normal(values[2 * i]));
  const double before = moments(Measurement::of_draws(2, values), 0)[0];
  const double after = moments(Measurement::of_draws(2, values, log_weights), 0)[0];
  CHECK(within(after - before, -2.0 * 0.09, 0.03));  // a Gaussian's shift: slope times variance
}

TEST_CASE("cohort: a prior that leaves few draws with weight cannot be taken back") {
  // Draws of a density narrower than the prior that made it so: weights exp(+z^2 / 2) fall on some draws at the edge.
  const std::vector<double> values = fractions(256, 0.4, 0.3);
  std::vector<double> log_weights;
  for (std::size_t i = 0; i < 256; ++i) {
    const double off = (decid::inverse_normal(values[2 * i]) - 0.4) / 0.3;
    log_weights.push_back(1.5 * off * off);
  }
  check_error([&] { (void)Measurement::of_draws(2, values, log_weights); }, Code::value_invalid);
}

TEST_CASE("cohort: a network's component keeps its precision, and one wider than the prior is cut at it") {
  const Measurement narrow = gaussian({0.5}, 0.5);
  CHECK(near(narrow.precision(0)[0], 5.0, 1e-12));
  CHECK(near(narrow.centre(0, 0), 0.5 * 4.0 / 5.0, 1e-12));
  CHECK(near(narrow.variance(0), 0.25, 1e-9));
  std::vector<double> outputs{0.0, 0.3, -0.4, -std::log(2.0), 0.0, 0.0};  // two parameters, sd 2 and 1
  const Measurement wide =
      Measurement::of_distribution(decid::ParameterDistribution(decid::Mixture(1, 2, outputs), unit_ranges(2)));
  CHECK(near(wide.precision(0)[0], 1.0, 1e-12));
  CHECK(near(wide.precision(0)[2], 1.0, 1e-12));
}

TEST_CASE("cohort: a covariance is cut along its axes only") {
  // A = ((1, 0), (a, 1)): precision A^t A, with eigenvalues on both sides of 1.
  const double a = 1.5;
  const std::vector<double> outputs{0.0, 0.0, 0.0, 0.0, 0.0, a};
  const Measurement found =
      Measurement::of_distribution(decid::ParameterDistribution(decid::Mixture(1, 2, outputs), unit_ranges(2)));
  const double trace = 2.0 + a * a, large = 0.5 * (trace + std::sqrt(trace * trace - 4.0));  // the small one is 1/large
  CHECK(near(found.precision(0)[0] + found.precision(0)[2], large + 1.0, 1e-10));
  CHECK(near(found.precision(0)[0] * found.precision(0)[2] - found.precision(0)[1] * found.precision(0)[1], large,
             1e-10));
}

TEST_CASE("cohort: draws that cannot be used are refused") {
  check_error([&] { (void)Measurement::of_draws(2, fractions(15, 0.0, 0.3)); }, Code::size_mismatch);
  std::vector<double> values = fractions(20, 0.0, 0.3);
  check_error([&] { (void)Measurement::of_draws(3, values); }, Code::size_mismatch);
  check_error([&] { (void)Measurement::of_draws(0, values); }, Code::size_mismatch);
  check_error([&] { (void)Measurement::of_draws(2, values, std::vector<double>(19, 0.0)); }, Code::size_mismatch);
  check_error([&] { (void)Measurement::of_draws(2, values, std::vector<double>(20, std::nan(""))); },
              Code::value_invalid);
  values[3] = std::nan("");
  check_error([&] { (void)Measurement::of_draws(2, values); }, Code::value_invalid);
}
