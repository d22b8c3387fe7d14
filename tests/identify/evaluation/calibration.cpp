// Calibration figures of made-up trials whose answers are known.
#include "identify/evaluation/calibration.hpp"

#include <cmath>

#include "base/math/math.hpp"
#include "base/math/random.hpp"
#include "posterior/streams.hpp"
#include "tests/helpers.hpp"
#include "tests/posterior/sampling/quick.hpp"
#include "tests/posterior/sampling/set_posterior.hpp"
#include "tests/posterior/trial.hpp"

using namespace decid;
using namespace decid::test;

namespace {

/// Normal posteriors of deviation `stated` whose means err by deviation 1.
std::vector<CalibratedTrial> trials_of(double stated, int count) {
  std::vector<CalibratedTrial> trials;
  for (int i = 0; i < count; ++i) {
    CalibratedTrial& trial = trials.emplace_back();
    const double error = Random(3, posterior::streams::chains, 0).normal(static_cast<std::uint64_t>(i));
    trial.truth = {10.0, 0.0};
    trial.mean = {10.0 + 2.0 * error, 0.0};
    trial.stddev = {2.0 * stated, 1.0};
    const double z = -error / stated;
    trial.below = {0.5 * std::erfc(-z / std::sqrt(2.0)), (i + 0.5) / count};
    trial.agreed = i % 4 != 0;
  }
  return trials;
}

}  // namespace

TEST_CASE("calibration_of: right posteriors are covered as they should be") {
  constexpr int count = 2000;
  const Calibration found = compute_calibration(trials_of(1.0, count), {2.0, 4.0});
  CHECK(found.trials == count);
  CHECK(found.agreed == count * 3 / 4);
  // 4 standard errors.
  CHECK(near(found.parameters[0].mse, 1.0, 4.0 * std::sqrt(2.0 / count)));
  CHECK(near(found.parameters[0].predicted_variance, 1.0, 1e-12));
  CHECK(within(found.parameters[0].coverage50, 0.5, 4.0 * 0.5 / std::sqrt(count)));
  CHECK(within(found.parameters[0].coverage90, 0.9, 4.0 * 0.3 / std::sqrt(count)));
  CHECK(found.parameters[0].distance < 1.5 * found.band);
  CHECK(near(found.band, 1.36 / std::sqrt(count), 1e-12));
  CHECK(near(found.band_of_all, 1.4802 / std::sqrt(count), 1e-4));  // of two: exceeded by 2.5% each
  CHECK(found.parameters[1].mse == 0.0);
  CHECK(near(found.parameters[1].predicted_variance, 1.0 / 16.0, 1e-12));
  CHECK(near(found.parameters[1].distance, 0.5 / count, 1e-9));
  CHECK(near(found.all.mse, 0.5 * found.parameters[0].mse, 1e-12));
  CHECK(found.all.distance == found.parameters[0].distance);
}

TEST_CASE("calibration_of: overconfident posteriors are detected") {
  const Calibration found = compute_calibration(trials_of(0.5, 400), {2.0, 4.0});
  CHECK(found.parameters[0].mse > 3.0 * found.parameters[0].predicted_variance);
  CHECK(found.parameters[0].coverage90 < 0.7);
  CHECK(found.parameters[0].distance > found.band);
}

TEST_CASE("calibration_of: those that agree alone, and none") {
  const std::vector<CalibratedTrial> trials = trials_of(1.0, 40);
  CHECK(calibration_of_agreeing(trials, {2.0, 4.0}).trials == 30);
  check_error([] { compute_calibration({}, {1.0}); }, Code::trials_missing);
}

TEST_CASE("calibration_of: a parameter that is fixed, but for rounding, does not count among all") {
  std::vector<CalibratedTrial> trials = trials_of(1.0, 40);
  for (CalibratedTrial& trial : trials) {
    trial.truth[1] = trial.mean[1] = 7.0;
    trial.stddev[1] = 1e-13;
    trial.below[1] = 0.0;
  }
  const Calibration found = compute_calibration(trials, {2.0, 4.0});
  CHECK(found.all.coverage90 == found.parameters[0].coverage90);
  CHECK(found.all.distance == found.parameters[0].distance);
}

TEST_CASE("gaussian_log_score: of Gaussian draws, and of draws that tell no covariance") {
  const decid::sim::ParameterTable& table = decid::sim::single_pendulum().parameters;
  constexpr int count = 4000;
  constexpr double spread = 0.3;
  const auto value = [&](std::size_t p, double x) { return table[p].low + table[p].range() * normal_distribution(x); };
  std::vector<posterior::State> draws(count, posterior::State{.parameters = decid::sim::Parameters(table.size())});
  decid::sim::Parameters truth(table.size());
  double exact = 0.0, of_others = 0.0;  // of all, of all but the last
  for (std::size_t p = 0; p < table.size(); ++p) {
    of_others = exact;
    const double centre = 0.2 * static_cast<double>(p) - 0.5, off = p % 2 == 0 ? 0.0 : spread;
    truth[p] = value(p, centre + off);
    // Over the standard normal density, which is that of the ranges.
    exact += 0.5 * (centre + off) * (centre + off) - 0.5 * off * off / (spread * spread) - std::log(spread);
    for (std::size_t i = 0; i < count; ++i) {
      draws[i].parameters[p] = value(p, centre + spread * Random(3, posterior::streams::chains, p).normal(i));
    }
  }
  // The last one is known but for 1e-5 once the first is: correlated, and far narrower than a network's A may be.
  constexpr double narrow = 1e-5;
  const std::size_t last = table.size() - 1;
  const double its_centre = 0.2 * static_cast<double>(last) - 0.5;
  truth[last] = value(last, its_centre);
  exact += std::log(spread) - std::log(narrow);
  for (std::size_t i = 0; i < count; ++i)
    draws[i].parameters[last] = value(last, its_centre + spread * Random(3, posterior::streams::chains, 0).normal(i) +
                                                narrow * Random(3, posterior::streams::chains, last).normal(i));
  exact /= static_cast<double>(table.size());
  // The logarithms of seven deviations err by 1 / sqrt(2 count), three squares by twice that: four deviations.
  CHECK(
      within(gaussian_log_score(truth, draws, table), exact, 4.0 / 7.0 * std::sqrt((7.0 + 3.0 * 6.0) / (2.0 * count))));
  // A fixed parameter does not count.
  for (std::size_t i = 0; i < count; ++i) draws[i].parameters[last] = truth[last] * (1.0 + 1e-15 * (i % 2 == 0));
  CHECK(within(gaussian_log_score(truth, draws, table), of_others / 6.0,
               4.0 / 6.0 * std::sqrt((6.0 + 3.0 * 6.0) / (2.0 * count))));
  std::fill(draws.begin(), draws.end(), draws.front());
  CHECK(std::isnan(gaussian_log_score(truth, draws, table)));
}

TEST_CASE("calibrate: chains of any of a person's recordings that do not agree count") {
  const sim::Protocol protocol = sines_protocol();
  const posterior::Density density(protocol, {});
  const posterior::Posterior drawn =
      posterior::sample(density, density.observe(recorded(protocol, some_parameters(), 0.02, 0)), quick());
  std::vector<posterior::Posterior> found(3, drawn);
  std::vector<double> rhat = drawn.rhat(), effective_draws = drawn.effective_draws();
  rhat.back() = 7.0;
  effective_draws.back() = 2.0;
  set_posterior(found[1], {drawn.states().begin(), drawn.states().end()}, rhat, effective_draws);
  const CalibratedTrial one = calibrate(some_parameters(), std::span(found).first(1), protocol.ranges()),
                        all = calibrate(some_parameters(), found, protocol.ranges());
  CHECK(one.rhat < 7.0);
  CHECK(one.effective_draws > 2.0);
  CHECK(all.rhat == 7.0);
  CHECK(all.effective_draws == 2.0);
  CHECK_FALSE(all.agreed);
  CHECK(all.mean == one.mean);
  CHECK(all.below == one.below);
  // Each parameter's fraction of draws below the truth.
  REQUIRE(one.below.size() == some_parameters().size());
  for (std::size_t p = 0; p < one.below.size(); ++p) {
    int below = 0;
    for (const posterior::State& state : drawn.states()) below += state.parameters[p] < some_parameters()[p] ? 1 : 0;
    CHECK(one.below[p] == static_cast<double>(below) / drawn.draws());
  }
}

TEST_CASE("calibration_by: three parts of equal size, in the key's order; a network's errors stand beside") {
  std::vector<CalibratedTrial> trials = trials_of(1.0, 31);
  for (std::size_t i = 0; i < trials.size(); ++i) {
    trials[i].truth[1] = static_cast<double>((i * 7) % 31);
    trials[i].network = decid::sim::Parameters{trials[i].truth[0] + 4.0, trials[i].truth[1]};
  }
  const auto parts = calibration_by(trials, {2.0, 4.0}, [](const decid::sim::Parameters& truth) { return truth[1]; });
  REQUIRE(parts.size() == 3);
  CHECK(parts[0].low == 0.0);
  CHECK(parts[0].high == 9.0);
  CHECK(parts[1].low == 10.0);
  CHECK(parts[2].high == 30.0);
  CHECK(parts[2].figures.trials == 11);
  for (const CalibrationPart& part : parts) {
    CHECK(near(part.figures.parameters[0].network_mse, 4.0, 1e-12));
    CHECK(near(part.figures.all.network_mse, 2.0, 1e-12));
  }
  trials[3].network = {};
  CHECK(std::isnan(compute_calibration(trials, {2.0, 4.0}).all.network_mse));
  check_error(
      [&] {
        calibration_by(std::span(trials).first(2), {2.0, 4.0}, [](const auto&) { return 0.0; });
      },
      Code::trials_missing, "2 trials");
}

// J = 100, 400 N m/rad beyond gravity: critical damping is 2 sqrt(100 * 400) = 400.
TEST_CASE("damping_ratio: of a body whose values are round") {
  decid::sim::Experiment experiment;
  decid::sim::Body& body = experiment.body;
  body.inertia_kgm2 = 100.0;
  decid::sim::Parameters parameters = decid::sim::single_pendulum().parameters.middle();
  parameters[decid::sim::Kp] = 500.0;
  parameters[decid::sim::Kp_pass] = 400.0 + body.mgh() - 1000.0;
  parameters[decid::sim::Kd] = 125.0;
  parameters[decid::sim::Kd_pass] = 50.0;
  parameters[decid::sim::Delay] = 0.1;
  CHECK(near(damping_ratio(parameters, experiment), 0.5, 1e-12));
  // The same loop: half the servo, half the weight of the gravity estimate, twice the gains.
  experiment.body_model = &decid::sim::dec2015();
  CHECK(near(damping_ratio({1000.0, 250.0, parameters[2], 50.0, 0.1, 0.0, 0.1, 0.6, 0.7, 0.4, 0.1}, experiment), 0.5,
             1e-12));
}
