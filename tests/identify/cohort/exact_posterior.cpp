// The hierarchical model against numerical integration of its posterior.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "base/math/math.hpp"
#include "base/math/random.hpp"
#include "identify/cohort/cohort.hpp"
#include "identify/cohort/detail/design.hpp"
#include "identify/cohort/detail/sampler.hpp"
#include "tests/identify/cohort/made_up.hpp"
#include "tests/near.hpp"

using decid::Random;
using decid::Stream;
using decid::cohort::Recording;
using decid::cohort::Result;
using namespace decid::test;

namespace {

/// The population's mean, as a fraction.
double mean_of(double mean, double log_sd) {
  return decid::normal_distribution(mean / std::sqrt(1.0 + std::exp(2.0 * log_sd)));
}

/// A value's expectation and standard deviation under the exact posterior, by a grid over the mean and the standard
/// deviation of coordinates, from the evidence's likelihood of mean and variance.
std::array<double, 2> by_grid(double noise_variance, const std::function<double(double, double)>& log_likelihood,
                              const std::function<double(double, double)>& value_of = mean_of) {
  double whole = 0.0, sum = 0.0, squares = 0.0;
  for (int i = 0; i < 800; ++i)
    for (int j = 0; j < 300; ++j) {
      const double mean = -4.0 + 0.01 * (i + 0.5), log_sd = std::log(0.001) * (1.0 - (j + 0.5) / 300.0);
      const double variance = std::exp(2.0 * log_sd);
      const double log_prior = -0.5 * mean * mean + log_sd - 0.5 * std::log(variance + noise_variance);
      const double weight = std::exp(log_prior + log_likelihood(mean, variance));
      const double value = value_of(mean, log_sd);
      whole += weight;
      sum += weight * value;
      squares += weight * value * value;
    }
  return {sum / whole, std::sqrt(squares / whole - sum * sum / whole / whole)};
}

double log_normal(double off, double variance) {
  return -0.5 * (off * off / variance + std::log(variance));
}

}  // namespace

TEST_CASE("cohort: a group's mean is that of the exact posterior") {
  const std::vector<double> all_at{-0.5, 0.9, 0.4, 0.1, 0.2}, all_sd{0.3, 0.2, 0.5, 0.8, 0.4};
  for (const std::size_t participants : {std::size_t{2}, std::size_t{5}}) {
    CAPTURE(participants);
    const std::span<const double> at = std::span(all_at).first(participants),
                                  sd = std::span(all_sd).first(participants);
    std::vector<Recording> recordings;
    double precision = 0.0;
    for (std::size_t i = 0; i < participants; ++i) {
      recordings.push_back({std::to_string(i), "", "", "", {}, gaussian({at[i]}, sd[i])});
      precision += 1.0 / (sd[i] * sd[i]) / static_cast<double>(participants);
    }
    const std::array<double, 2> exact = by_grid(1.0 / precision, [&](double centre, double variance) {
      double sum = 0.0;
      for (std::size_t i = 0; i < participants; ++i) sum += log_normal(at[i] - centre, variance + sd[i] * sd[i]);
      return sum;
    });
    const Result found = analyse(recordings, 1);
    const double mean = exact[0], stddev = exact[1];
    CAPTURE(mean);
    CAPTURE(stddev);
    REQUIRE(found.cells.size() == 1);
    CHECK(found.cells[0].participants == participants);
    // 6,000 draws, at least 1,500 of them effective: four standard errors.
    CHECK(within(found.cells[0].mean[0].mean, mean, 4.0 * stddev / std::sqrt(1500.0)));
    CHECK(near(found.cells[0].mean[0].sd, stddev, 4.0 / std::sqrt(2.0 * 1500.0)));
    CHECK(found.max_rhat < 1.05);
    CHECK(found.comparisons.empty());
  }
}

TEST_CASE("cohort: the standard deviation of persons that are known exactly is that of the exact posterior") {
  // So precise that only the move given the deviations goes far.
  const std::vector<double> at{-0.5, 0.9, 0.4};
  constexpr double noise_variance = 1e-4;
  std::vector<Recording> recordings;
  for (const double value : at)
    recordings.push_back({std::to_string(value), "", "", "", {}, gaussian({value}, std::sqrt(noise_variance))});
  const std::array<double, 2> exact = by_grid(
      noise_variance,
      [&](double centre, double variance) {
        double sum = 0.0;
        for (const double value : at) sum += log_normal(value - centre, variance + noise_variance);
        return sum;
      },
      [](double, double log_sd) { return log_sd; });
  const double mean = exact[0], stddev = exact[1];
  const decid::cohort::Design design = decid::cohort::make_design(recordings, 1, {});
  double found = 0.0;
  constexpr int chains = 4, sweeps = 4000;
  for (std::size_t chain = 0; chain < chains; ++chain) {
    decid::cohort::Sampler sampler(design, recordings, 1, chain);
    for (int i = 0; i < 200; ++i) sampler.sweep();
    for (int i = 0; i < sweeps; ++i) {
      sampler.sweep();
      found += std::log(sampler.draw().participant_sd[0]) / (chains * sweeps);
    }
  }
  CAPTURE(mean);
  CAPTURE(stddev);
  // At least one effective draw of four; one person too many would add 0.3 standard deviations.
  CHECK(within(found, mean, 4.0 * stddev / std::sqrt(chains * sweeps / 4.0)));
}

TEST_CASE("cohort: evidence with two modes, from draws, is that of the exact posterior") {
  // Under its uniform prior a recording has modes at -1 and 1 of sd 0.2; three others are precise, near 0.8.
  const Random random(8, Stream::user, 1);
  std::vector<double> draws;
  for (std::uint64_t i = 0; i < 4096; ++i)
    draws.push_back(decid::normal_distribution((i / 16 % 2 == 0 ? -1.0 : 1.0) + 0.2 * random.normal(i)));
  std::vector<Recording> recordings{{"x", "", "", "", {}, decid::cohort::Measurement::of_draws(1, draws)}};
  const std::vector<double> at{0.7, 0.8, 0.9};
  double precision = 1.0 / recordings[0].measurement.variance(0);
  for (const double value : at) {
    recordings.push_back({std::to_string(value), "", "", "", {}, gaussian({value}, 0.1)});
    precision += 100.0;
  }
  // Evidence of a mode: precision 25 - 1, mean 25 m / 24; both modes weigh the same.
  const std::array<double, 2> exact = by_grid(4.0 / precision, [&](double centre, double variance) {
    double sum = 0.0;
    for (const double value : at) sum += log_normal(value - centre, variance + 0.01);
    const double wide = variance + 1.0 / 24.0, below = log_normal(-25.0 / 24.0 - centre, wide);
    return sum + std::log(std::exp(below) + std::exp(log_normal(25.0 / 24.0 - centre, wide)));
  });
  const Result found = analyse(recordings, 1);
  const double mean = exact[0], stddev = exact[1];
  CAPTURE(mean);
  CAPTURE(stddev);
  CHECK(within(found.cells[0].mean[0].mean, mean, 0.15 * stddev));
  CHECK(near(found.cells[0].mean[0].sd, stddev, 0.15));
}
