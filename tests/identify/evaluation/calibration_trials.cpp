// The trials of a calibration: they continue from any attempt, and stop.
#include "identify/evaluation/calibration_trials.hpp"

#include <cmath>

#include "tests/helpers.hpp"
#include "tests/posterior/sampling/quick.hpp"
#include "tests/posterior/trial.hpp"
#include "tests/sim/tiny_protocol.hpp"

using namespace decid;

TEST_CASE("CalibrationTrials: an attempt gives the same trial, and trials differ") {
  const sim::Protocol protocol = sim::default_protocol();
  const posterior::Priors priors{.start_s = 0.1, .gain = 0.0};
  CalibrationTrials trials(std::span(&protocol, 1), priors, 7), again(std::span(&protocol, 1), priors, 7);
  const CalibrationTrials::Trial first = trials.next(), second = trials.next();
  CHECK(first.attempt < second.attempt);
  CHECK(first.sway_rad != second.sway_rad);
  again.seek(second.attempt);
  CHECK(again.next().sway_rad == second.sway_rad);
  CalibrationTrials known(std::span(&protocol, 1), {.start_s = 0.0, .gain = 0.0}, 7);
  known.seek(second.attempt);
  const CalibrationTrials::Trial unmoved = known.next();
  CHECK(unmoved.truth == second.truth);
  CHECK(unmoved.sway_rad != second.sway_rad);
}

TEST_CASE("CalibrationTrials: later recordings of a person have the same parameters and their own noise") {
  const posterior::Priors priors{.start_s = 0.0, .gain = 0.0};
  const std::vector<sim::Protocol> protocols{sim::default_protocol(), sim::short_protocol(), sim::default_protocol()};
  const CalibrationTrials::Trial trial = CalibrationTrials(protocols, priors, 7).next();
  REQUIRE(trial.others_rad.size() == 2);
  CHECK(trial.sway_rad == CalibrationTrials(std::span(protocols).first(1), priors, 7).next().sway_rad);
  CHECK(trial.others_rad[0].size() == static_cast<std::size_t>(protocols[1].samples()));
  CHECK(trial.others_rad[1].size() == trial.sway_rad.size());
  CHECK(trial.others_rad[1] != trial.sway_rad);
  test::check_error([&] { CalibrationTrials(std::span<const sim::Protocol>(), priors, 7); }, Code::value_invalid);
  sim::Protocol other = sim::default_protocol();
  other.experiment.body_model = &sim::independent_channels();
  test::check_error([&] { CalibrationTrials(std::vector{protocols[0], other}, priors, 7); }, Code::value_invalid);
}

TEST_CASE("calibrate_trial: recordings of a person tell more together") {
  sim::Protocol protocol = test::sines_protocol();
  protocol.noise.sensor = {0.02, 0.02};
  const posterior::Priors priors{.start_s = 0.0, .gain = 0.0};
  std::vector<sim::Protocol> protocols{protocol};
  std::deque<posterior::Density> densities;
  double variance[2];
  for (const std::size_t count : {std::size_t{1}, std::size_t{4}}) {
    protocols.resize(count, protocol);
    while (densities.size() < count) densities.emplace_back(protocol, priors);
    CalibrationTrials trials(protocols, priors, 7);
    const std::optional<CalibratedTrial> found =
        calibrate_trial(densities, trials.next(), protocol.ranges(), test::quick(), [] { return false; });
    REQUIRE(found);
    double sum = 0.0;
    for (std::size_t p = 0; p < found->truth.size(); ++p)
      sum += std::pow(found->stddev[p] / protocol.ranges()[p].range(), 2);
    variance[count == 1 ? 0 : 1] = sum;
  }
  CHECK(variance[1] < 0.7 * variance[0]);
}

TEST_CASE("CalibrationTrials: a protocol in which every trial falls is refused") {
  sim::Protocol protocol = test::tiny_protocol();
  protocol.sequence().cycles = 5;  // a fall takes seconds
  // No controller of these ranges holds a body up.
  std::vector<sim::ParameterInfo> weak(protocol.parameters().begin(), protocol.parameters().end());
  weak[sim::Kp].low = 1.0;
  weak[sim::Kp].high = 2.0;
  const sim::BodyModel model{
      .name = "weak", .parameters = sim::ParameterTable(weak), .family = sim::single_pendulum().family};
  protocol.experiment.body_model = &model;
  CalibrationTrials trials(std::span(&protocol, 1), {}, 7);
  test::check_error([&] { trials.next(); }, Code::body_falls, "tiny");
}

TEST_CASE("with_priors: start and gain of every trial vary with the prior's standard deviation") {
  const sim::Protocol protocol = with_priors(sim::default_protocol(), {.start_s = 0.2, .gain = 0.1});
  CHECK(protocol.conditions[sim::Condition::start].fraction == 1.0);
  CHECK(protocol.conditions[sim::Condition::start].high == 0.2);
  CHECK(protocol.conditions[sim::Condition::gain].high == std::sqrt(3.0) * 0.1);
  const sim::Protocol known = with_priors(sim::default_protocol(), {.start_s = 0.0, .gain = 0.0});
  CHECK(known.conditions[sim::Condition::start].fraction == 0.0);
  CHECK(known.conditions[sim::Condition::gain].fraction == 0.0);
}

TEST_CASE("uniform_stddev: the range over the root of 12") {
  const sim::ParameterTable ranges = sim::default_protocol().ranges();
  const sim::Parameters stddev = uniform_stddev(ranges);
  REQUIRE(stddev.size() == ranges.size());
  for (std::size_t p = 0; p < ranges.size(); ++p) CHECK(stddev[p] == ranges[p].range() / std::sqrt(12.0));
}

TEST_CASE("calibrate_trial: stops when asked") {
  const sim::Protocol protocol = sim::default_protocol();
  const posterior::Priors priors{.start_s = 0.0, .gain = 0.0};
  std::deque<posterior::Density> densities;
  densities.emplace_back(protocol, priors);
  CalibrationTrials trials(std::span(&protocol, 1), priors, 7);
  CHECK_FALSE(calibrate_trial(densities, trials.next(), protocol.ranges(), {}, [] { return true; }).has_value());
}

TEST_CASE("NetworkAnswers: answers of a network for its own experiment only") {
  const Model model = built_in_model();
  CalibrationTrials trials(std::span(&model.protocol, 1), {.start_s = 0.0, .gain = 0.0}, 7);
  const CalibrationTrials::Trial trial = trials.next();
  CalibratedTrial calibrated;
  calibrated.truth = trial.truth;
  NetworkAnswers network(model, model.protocol);
  CHECK(network.sha256() == nn::weights_sha256(model.network));
  network.answer(trial.sway_rad, calibrated);
  REQUIRE(calibrated.network.has_value());
  CHECK(model.parameters().size() == calibrated.network->size());

  sim::Protocol other = model.protocol;
  other.experiment.body.mass_kg += 1.0;
  NetworkAnswers none(model, other);
  CHECK(none.sha256().empty());
  calibrated.network.reset();
  none.answer(trial.sway_rad, calibrated);
  CHECK_FALSE(calibrated.network.has_value());
}
