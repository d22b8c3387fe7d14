// The posterior of planned recordings: limits that are known exactly, and the direction of a protocol's change.
// tests/identify/cohort/planned_fits.cpp compares with fits.
#include "posterior/planning/expected_posterior.hpp"

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

TEST_CASE("planning: a fixed parameter has no uncertainty and lowers that of others") {
  const sim::Protocol protocol = sines_protocol();
  const sim::Parameters at = some_parameters();
  Priors priors;
  priors.parameters.push_back({.name = "Kp_pass", .fixed = at[sim::Kp_pass]});
  const ExpectedPosterior fixed = expected_posterior(Density(protocol, priors), {.draws = 8, .at = at});
  const ExpectedPosterior all = expected_posterior(Density(protocol, {}), {.draws = 8, .at = at});
  CHECK(fixed.sd[sim::Kp_pass] == 0.0);
  CHECK(fixed.relative_variance[sim::Kp_pass] == 0.0);
  CHECK(fixed.sd[sim::Kp] < all.sd[sim::Kp]);
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
