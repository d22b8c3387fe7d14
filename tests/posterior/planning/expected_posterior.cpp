// The posterior of planned recordings: limits that are known exactly, and the direction of a protocol's change.
// tests/identify/cohort/planned_fits.cpp compares with fits.
#include "posterior/planning/expected_posterior.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "posterior/planning/bounded_normal.hpp"
#include "posterior/planning/variations.hpp"
#include "tests/helpers.hpp"
#include "tests/near.hpp"
#include "tests/posterior/trial.hpp"

using namespace decid;
using namespace decid::posterior;
using namespace decid::test;

TEST_CASE("planning: variances within ranges") {
  const std::vector<FractionPrior> uniform(2);
  CHECK(near(prior_variances(uniform)[0], 1.0 / 12.0, 1e-5));
  const std::vector<FractionPrior> narrow{{0.4, 1.0 / (0.05 * 0.05)}};
  CHECK(near(prior_variances(narrow)[0], 0.05 * 0.05, 1e-5));
  for (const double sd : {0.02, 0.005, 1e-4}) {
    CAPTURE(sd);
    const std::vector<FractionPrior> narrower{{0.3, 1.0 / (sd * sd)}, {0.0, 1.0 / (sd * sd)}, {0.5, 1e-8}};
    const std::vector<double> variances = prior_variances(narrower);
    CHECK(near(variances[0], sd * sd, 1e-6));
    CHECK(near(variances[1], (1.0 - 2.0 / sim::pi) * sd * sd, 1e-2));  // a half of it, by the grid at its edge
    CHECK(near(variances[2], 1.0 / 12.0, 1e-5));
  }
  // 1,000 draws: four standard errors of a variance of independent uniform ones are 11%.
  const Random random(7, Stream::user, 0);
  const std::vector<double> truth{0.3, 0.6}, nothing{0.0, 0.0, 0.0};
  for (const double variance : variances_in_range(truth, nothing, uniform, random))
    CHECK(near(variance, 1.0 / 12.0, 0.12));
  // Far from the ends: the inverse of the information, here with a correlation of -0.6; its chain forgets in five
  // draws, so four standard errors are 0.3.
  const double a = 1.0 / (0.02 * 0.02 * 0.64);
  const std::vector<double> much{a, 0.6 * a, a};
  for (const double variance : variances_in_range(truth, much, uniform, random))
    CHECK(near(variance, 0.02 * 0.02, 0.3));
  // A normal prior counts: half of the variance if both tell as much.
  const std::vector<double> one{1.0 / (0.02 * 0.02)}, middle{0.5};
  const std::vector<FractionPrior> same{{0.5, 1.0 / (0.02 * 0.02)}};
  CHECK(near(variances_in_range(middle, one, same, random)[0], 0.5 * 0.02 * 0.02, 0.2));
}

namespace {

/// The variances of a normal distribution within the unit square, on a grid.
std::array<double, 2> variances_on_grid(double a, double b, double c, const std::array<double, 2>& pull) {
  constexpr int grid = 100;
  double whole = 0.0;
  std::array<double, 2> first{}, second{};
  const auto exponent = [&](double u, double v) {
    return pull[0] * u + pull[1] * v - 0.5 * (a * u * u + 2.0 * b * u * v + c * v * v);
  };
  double largest = exponent(0.5, 0.5);
  for (int i = 0; i < grid; ++i)
    for (int j = 0; j < grid; ++j) largest = std::max(largest, exponent((i + 0.5) / grid, (j + 0.5) / grid));
  for (int i = 0; i < grid; ++i)
    for (int j = 0; j < grid; ++j) {
      const double u = (i + 0.5) / grid, v = (j + 0.5) / grid;
      const double density = std::exp(exponent(u, v) - largest);
      whole += density;
      first[0] += density * u;
      first[1] += density * v;
      second[0] += density * u * u;
      second[1] += density * v * v;
    }
  for (std::size_t k = 0; k < 2; ++k) second[k] = second[k] / whole - first[k] / whole * (first[k] / whole);
  return second;
}

}  // namespace

// 100 estimates of 1,000 sweeps: the mean ratio has a standard error of about 1%. Axes alone give 0.95.
TEST_CASE("planning: the variances of parameters that trade off closely within their ranges") {
  constexpr double sd = 0.2, correlation = 0.99;
  const double a = 1.0 / (sd * sd * (1.0 - correlation * correlation)), b = -correlation * a;
  const std::vector<double> information{a, b, a}, truth{0.3, 0.35};
  const std::vector<FractionPrior> uniform(2);
  double ratio = 0.0;
  constexpr int estimates = 100;
  for (std::uint64_t item = 0; item < estimates; ++item) {
    const Random random(7, Stream::user, item);
    // The estimate that variances_in_range() draws.
    const double l11 = std::sqrt(a), l21 = b / l11, l22 = std::sqrt(a - l21 * l21);
    const std::array<double, 2> pull{a * truth[0] + b * truth[1] + l11 * random.normal(0),
                                     b * truth[0] + a * truth[1] + l21 * random.normal(0) + l22 * random.normal(1)};
    const std::array<double, 2> exact = variances_on_grid(a, b, a, pull);
    const std::vector<double> found = variances_in_range(truth, information, uniform, random);
    ratio += 0.5 * (found[0] / exact[0] + found[1] / exact[1]) / estimates;
  }
  CHECK(within(ratio, 1.0, 0.03));
}

TEST_CASE("planning: noise, stimulus and length change what a recording tells as they must") {
  const sim::Protocol protocol = sines_protocol();
  const Density density(protocol, {});
  const ExpectedPosterior quiet = expected_posterior(density, {.draws = 8, .sensor_noise_deg = 0.01});
  const ExpectedPosterior noisy = expected_posterior(density, {.draws = 8, .sensor_noise_deg = 0.3});
  CHECK(quiet.figure_of_merit < 0.7 * noisy.figure_of_merit);
  CHECK(noisy.figure_of_merit < 1.05);
  CHECK(quiet.figure_error > 0.0);
  CHECK(near(quiet.prior_sd[sim::Delay], density.ranges()[sim::Delay].range() / std::sqrt(12.0), 1e-5));
  CHECK(near(quiet.sd[sim::Kp], quiet.prior_sd[sim::Kp] * std::sqrt(quiet.relative_variance[sim::Kp]), 1e-12));
  CHECK(expected_posterior(density, {.draws = 8, .sensor_noise_deg = 0.01}).sd == quiet.sd);
  CHECK(expected_posterior(density, {.draws = 8, .sensor_noise_deg = 0.01, .seed = 2}).sd != quiet.sd);

  const Density larger(with_peak_to_peak(protocol, 8.0), {});
  CHECK(near(sim::make_stimulus(larger.protocol().experiment).peak_to_peak_rad() / sim::rad_per_deg, 8.0, 1e-9));
  const sim::Parameters at = some_parameters();
  const ExpectedPosterior one = expected_posterior(density, {.draws = 8, .at = at});
  const Density smaller(with_peak_to_peak(protocol, 0.1), {});
  CHECK(expected_posterior(larger, {.draws = 8, .at = at}).figure_of_merit <
        0.9 * expected_posterior(smaller, {.draws = 8, .at = at}).figure_of_merit);
  const Density longer(with_cycles(sines(0.1, 0.3, 20.0, 1, 20.0), 3), {});
  CHECK(near(longer.protocol().duration_s(), 60.0, 1e-9));
  CHECK(expected_posterior(longer, {.draws = 8, .at = at}).sd[sim::Kd] < one.sd[sim::Kd]);
}

// In independent channels the noise passes with a gain of 1 - W. Nv times this gain is what the noise's power tells, so
// relative to their values Nv is as uncertain as the gain. In calibrated fits Nv's sd is three times as large above a W
// of 0.9 as below 0.5.
TEST_CASE("planning: the gain of the tilt estimate trades off with the noise") {
  sim::Protocol protocol = sines_protocol();
  protocol.experiment.body_model = &sim::independent_channels();
  const Density density(protocol, {});
  const sim::ParameterTable& table = protocol.parameters();
  const auto place = [&](const char* name) {
    return static_cast<std::size_t>(
        std::distance(table.begin(), std::ranges::find(table, name, &sim::ParameterInfo::name)));
  };
  const auto sd_with = [&](double weight) {
    sim::Parameters at = table.middle();
    at[place("W")] = weight;
    return expected_posterior(density, {.draws = 8, .at = at}).sd[place("Nv")];
  };
  CHECK(sd_with(0.95) > 1.5 * sd_with(0.3));
}

TEST_CASE("planning: a fixed parameter has no uncertainty and lowers that of others") {
  const sim::Protocol protocol = sines_protocol();
  const sim::Parameters at = some_parameters();
  Priors priors;
  priors.parameters.push_back({.name = "Kp_pass", .fixed = at[sim::Kp_pass]});
  const ExpectedPosterior fixed = expected_posterior(Density(protocol, priors), {.draws = 8, .at = at});
  const ExpectedPosterior all = expected_posterior(Density(protocol, {}), {.draws = 8, .at = at});
  CHECK(fixed.sd[sim::Kp_pass] == 0.0);
  CHECK(fixed.at == at);
  CHECK_FALSE(expected_posterior(Density(protocol, priors), {.draws = 8}).at);
  CHECK(fixed.relative_variance[sim::Kp_pass] == 0.0);
  CHECK(fixed.sd[sim::Kp] < all.sd[sim::Kp]);
}

TEST_CASE("planning: a person near the end of a range is planned for 1% of it within, and the result says so") {
  const Density density(sines_protocol(), {});
  sim::Parameters at = some_parameters();
  const sim::ParameterInfo& delay = density.ranges()[sim::Delay];
  at[sim::Delay] = delay.low + 0.004 * delay.range();
  sim::Parameters inside = at;
  inside[sim::Delay] = delay.low + 0.01 * delay.range();
  const ExpectedPosterior found = expected_posterior(density, {.draws = 8, .at = at});
  CHECK(found.at == inside);
  CHECK(found.sd == expected_posterior(density, {.draws = 8, .at = inside}).sd);
}

TEST_CASE("planning: plans that cannot be are refused") {
  const sim::Protocol protocol = sines_protocol();
  const Density density(protocol, {});
  check_error([&] { (void)expected_posterior(density, {.draws = 0}); }, Code::setting_out_of_range);
  check_error([&] { (void)expected_posterior(density, {.sensor_noise_deg = 0.0}); }, Code::setting_out_of_range);
  sim::Parameters at = some_parameters();
  at[sim::Delay] = 0.5;
  check_error([&] { (void)expected_posterior(density, {.at = at}); }, Code::setting_out_of_range);
  check_error([&] { (void)expected_posterior(density, {.at = sim::Parameters(3)}); }, Code::size_mismatch);
  Priors priors;
  for (const sim::ParameterInfo& info : protocol.parameters())
    priors.parameters.push_back({.name = info.name, .fixed = 0.5 * (info.low + info.high)});
  check_error([&] { (void)expected_posterior(Density(protocol, priors), {}); }, Code::setting_conflict);
  check_error([&] { (void)with_peak_to_peak(protocol, 0.0); }, Code::setting_out_of_range);
  check_error([&] { (void)with_cycles(protocol, 0); }, Code::setting_out_of_range);
}
