// Predictions of decid design beside fits of simulated recordings: the figures of docs/guide/design.md. A fit takes 5
// to 30 s of a core, so the test has the suite long; tests/posterior/planning/ has the fast ones.
#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <vector>

#include "base/parallel.hpp"
#include "base/text.hpp"
#include "identify/evaluation/calibration_trials.hpp"
#include "posterior/planning/expected_posterior.hpp"
#include "recording/protocol_file.hpp"
#include "sim/body_model.hpp"

using namespace decid;

namespace {

struct Variances {
  double predicted = 0.0, fitted = 0.0, squared_error = 0.0;
};

/// Sums over persons, relative to the prior's variance; per parameter.
std::vector<Variances> beside_fits(sim::Protocol protocol, int participants) {
  constexpr double noise_deg = 0.02;
  protocol.noise.sensor = {noise_deg, noise_deg};
  const posterior::Priors priors{.start_s = 0.0, .gain = 0.0};
  const posterior::Density density(protocol, priors);
  CalibrationTrials source(std::span(&protocol, 1), priors, 901);
  std::vector<CalibrationTrials::Trial> trials;
  for (int i = 0; i < participants; ++i) trials.push_back(source.next());
  std::vector<std::vector<Variances>> all(trials.size());
  parallel_for(participants, [&](int i) {
    const CalibrationTrials::Trial& trial = trials[static_cast<std::size_t>(i)];
    posterior::Settings settings;
    settings.seed = trial.attempt;
    const posterior::Posterior found = posterior::sample(density, density.observe(trial.sway_rad), settings);
    const posterior::ExpectedPosterior expected =
        posterior::expected_posterior(density, {.draws = 8, .sensor_noise_deg = noise_deg, .at = trial.truth});
    for (std::size_t p = 0; p < trial.truth.size(); ++p) {
      const double prior = expected.prior_sd[p] * expected.prior_sd[p];
      const double sd = found.stddev(static_cast<int>(p)), error = found.mean(static_cast<int>(p)) - trial.truth[p];
      all[static_cast<std::size_t>(i)].push_back(
          {expected.relative_variance[p], sd * sd / prior, error * error / prior});
    }
  });
  std::string of_people = "sd of Kp over the prior's, predicted/fitted, of each person:";
  for (const std::vector<Variances>& one : all)
    of_people += format(" %.3f/%.3f", std::sqrt(one[sim::Kp].predicted), std::sqrt(one[sim::Kp].fitted));
  MESSAGE(of_people);
  std::vector<Variances> sums(trials.front().truth.size());
  for (const std::vector<Variances>& one : all)
    for (std::size_t p = 0; p < one.size(); ++p) {
      sums[p].predicted += one[p].predicted / participants;
      sums[p].fitted += one[p].fitted / participants;
      sums[p].squared_error += one[p].squared_error / participants;
    }
  return sums;
}

// With 20 persons a parameter's ratio has a standard error of about 0.05, from the persons whose fits vary most.
void check_prediction(const std::string& name, const sim::Protocol& protocol) {
  Variances all;
  std::string text = name + ":";
  for (const Variances& one : beside_fits(protocol, 20)) {
    const double ratio = std::sqrt(one.predicted / one.fitted);
    text += " " + std::to_string(ratio);
    CHECK(ratio > 0.82);
    CHECK(ratio < 1.18);
    all.predicted += one.predicted / 7.0;
    all.fitted += one.fitted / 7.0;
    all.squared_error += one.squared_error / 7.0;
  }
  const double ratio = std::sqrt(all.predicted / all.fitted);
  CHECK(ratio > 0.9);
  CHECK(ratio < 1.1);
  MESSAGE(text << "; all " << ratio << "; predicted " << all.predicted << ", fits " << all.fitted << ", squared errors "
               << all.squared_error);
}

}  // namespace

TEST_CASE("design: predictions beside fits" * doctest::test_suite("long")) {
  check_prediction("default", sim::default_protocol());
  check_prediction("short", sim::short_protocol());
  sim::Protocol larger = sim::default_protocol();
  larger.sequence().amplitude_deg = 4.0;
  check_prediction("default, 4 deg", larger);
  check_prediction("seven sines", recording::load_protocol(DECID_SOURCE_DIR "/examples/seven_sines.json"));
}
