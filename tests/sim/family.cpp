// Tests of sim/family.hpp and sim/body_model.hpp: every model of the family against its equations written straight
// down, a model of a test among them, and against its transfer function.
#include "sim/family.hpp"

#include <algorithm>
#include <cmath>

#include "base/isa.hpp"
#include "sim/protocol/protocol_json.hpp"
#include "tests/helpers.hpp"
#include "tests/sim/run.hpp"
#include "tests/sim/straightforward.hpp"
#include "tests/sim/third_model.hpp"
#include "tests/sim/tiny_protocol.hpp"

using namespace decid::sim;
using namespace decid::test;

namespace {

/// 12 s, short as the equations written straight down take most of these tests' time.
Protocol brief_protocol(const BodyModel& model) {
  Protocol protocol = with_model(tiny_protocol(), model);
  protocol.sequence().amplitude_deg = 1.0;
  protocol.sequence().state_s = 0.15;
  return protocol;
}

/// The samples among the steps of a trial by the equations.
std::vector<double> samples_of(const Protocol& protocol, const std::vector<double>& steps) {
  std::vector<double> sway;
  for (std::size_t k = 0; k + 1 < steps.size(); k += static_cast<std::size_t>(protocol.experiment.steps_per_sample()))
    sway.push_back(steps[k]);
  return sway;
}

/// The sway of the samples by the equations.
std::vector<double> expected_sway(const Protocol& protocol, const Parameters& parameters) {
  return samples_of(protocol, straightforward(protocol, parameters, some_noise));
}

/// Returns the largest difference over the largest expected value.
double relative_difference(const std::vector<double>& expected, const std::vector<double>& found) {
  double largest = 0.0, difference = 0.0;
  for (std::size_t k = 0; k < expected.size(); ++k) {
    largest = std::max(largest, std::abs(expected[k]));
    difference = std::max(difference, std::abs(expected[k] - found[k]));
  }
  return difference / largest;
}

}  // namespace

TEST_CASE("Family: the simulator equals the equations written straight down, for every model") {
  for (const BodyModel* model : all_models()) {
    CAPTURE(model->name);
    const Protocol protocol = brief_protocol(*model);
    const Simulator simulator(protocol);
    for (const double place : {0.5, 0.35}) {
      const std::vector<double> unit(model->parameters.size(), place);
      const Parameters parameters = model->parameters.from_unit(unit);
      const Run trial = simulate(simulator, parameters);
      REQUIRE(trial.outcome.valid);
      // Slow states keep errors of rounding for some 10,000 steps.
      CHECK(relative_difference(expected_sway(protocol, parameters), trial.sway) < 1e-11);
    }
  }
}

TEST_CASE("Simulator: equals the equations written straight down, for every delay, sample rate, noise and body") {
  // Up to the fall, where there is one.
  const auto check = [](const Protocol& protocol, const Parameters& parameters) {
    const std::vector<double> steps = straightforward(protocol, parameters, some_noise);
    const std::vector<double> expected = samples_of(protocol, steps);
    const Run trial = simulate(Simulator(protocol), parameters);
    CHECK(expected.size() > trial.sway.size() / 10);
    CHECK(trial.outcome.valid == (expected.size() == trial.sway.size()));
    CHECK(relative_difference(expected, trial.sway) < 1e-11);
    double largest = 0.0;
    for (const double a : steps) largest = std::max(largest, std::abs(a));
    if (trial.outcome.valid) CHECK(near(trial.outcome.max_sway_rad, largest, 1e-11));
  };
  const Protocol brief = brief_protocol(single_pendulum());
  const Parameters middle = single_pendulum().parameters.middle();
  // Whole steps, up to the longest, and parts of them; 0.1 + 0.02 is above 0.12.
  for (const double delay :
       {0.0, 0.001, 0.0004, 0.0025, 0.0105, 0.07, 0.12, 0.1 + 0.02, 0.12025, 0.2399, 0.24, 0.9995, 1.0}) {
    CAPTURE(delay);
    Parameters parameters = middle;
    parameters[Delay] = delay;
    check(brief, parameters);
  }
  Parameters parameters = middle;
  parameters[Nv] = 0.0;
  check(brief, parameters);
  parameters[Theta] = 0.0;
  check(brief, parameters);
  for (const double rate_hz : {20.0, 1000.0}) {
    Protocol other = brief;
    other.experiment.sample_rate_hz = rate_hz;
    other.sequence().amplitude_deg = 4.0;
    other.experiment.body.mass_kg = 60.0;
    check(other, middle);
  }
}

TEST_CASE("Family: a dead band before the gravity gain, for every model and instruction set") {
  for (const BodyModel* model : all_models()) {
    CAPTURE(model->name);
    Protocol protocol = brief_protocol(*model);
    const Parameters parameters = model->parameters.middle();
    const Run without = simulate(Simulator(protocol), parameters);
    protocol.gravity_dead_band_deg = 0.07;
    const std::vector<double> expected = expected_sway(protocol, parameters);
    const Run plain = simulate(Simulator(protocol, decid::Isa::reference), parameters);
    REQUIRE(plain.outcome.valid);
    CHECK(relative_difference(expected, plain.sway) < 1e-11);
    // `ic` has no gravity gain.
    CHECK((relative_difference(without.sway, plain.sway) > 0.01) == (model != &independent_channels()));
    for (const decid::Isa isa : decid::available_isas()) {
      CAPTURE(name(isa));
      CHECK(simulate(Simulator(protocol, isa), parameters).sway == plain.sway);
      protocol.gravity_dead_band_deg = 0.0;
      CHECK(simulate(Simulator(protocol, isa), parameters).sway == without.sway);
      protocol.gravity_dead_band_deg = 0.07;
    }
    const Protocol read = protocol_from_json(to_json(protocol), "test");
    CHECK(read.gravity_dead_band_deg == 0.07);
    CHECK(to_json(read) == to_json(protocol));
  }
  CHECK(!contains(to_json(default_protocol()), "dead_band"));
  check_error([] { protocol_from_json(R"({"gravity_dead_band_deg": -0.1})", "p.json"); },
              decid::Code::setting_out_of_range, "-0.1");
  check_error([] { protocol_from_json(R"({"gravity_dead_band_deg": 5.1})", "p.json"); },
              decid::Code::setting_out_of_range, "5.1");
}

TEST_CASE("Family: the parameter that alone determines a coefficient") {
  CHECK(single_pendulum().family.find_parameter(Coefficient::nv) == Nv);
  CHECK(!single_pendulum().family.find_parameter(Coefficient::slow));
  CHECK(independent_channels().family.find_parameter(Coefficient::tilt) == 2);
  Family family = third_model().family;
  CHECK(family.find_parameter(Coefficient::gravity) == 3);
  family.terms.push_back({4, Coefficient::gravity});
  CHECK(!family.find_parameter(Coefficient::gravity));
}

TEST_CASE("Family: small sway follows each model's transfer function") {
  for (const BodyModel* model : all_models()) {
    CAPTURE(model->name);
    Protocol protocol = with_model({}, *model);
    protocol.sequence().amplitude_deg = 0.01;
    protocol.sequence().cycles = 6;  // slow feedback has settled in the last one
    Parameters parameters = model->family.without_noise(model->parameters.middle());
    for (std::size_t i = 0; i < parameters.size(); ++i)
      if (model->parameters[i].name == "theta") parameters[i] = 0.0;
    const Simulator simulator(protocol);
    const Run trial = simulate(simulator, parameters);
    REQUIRE(trial.outcome.valid);
    constexpr int cycle = 6050;
    const RealFft fft(cycle);
    std::vector<Complex> tilt(static_cast<std::size_t>(fft.bins())), sway(tilt.size());
    std::vector<Complex> work(static_cast<std::size_t>(fft.work_length()));
    const std::vector<double>& tilt_rad = simulator.stimulus().tilt_rad;
    fft.forward(std::span(tilt_rad).subspan(std::size_t{5} * cycle, cycle), tilt, work);
    fft.forward(std::span(trial.sway).subspan(std::size_t{5} * cycle, cycle), sway, work);
    double worst = 0.0;
    for (std::size_t k = 1; k < 73; k += 2) {
      const Complex expected = closed_loop(protocol.experiment, parameters, static_cast<double>(k) / 60.5);
      worst = std::max(worst, std::abs(sway[k] / tilt[k] - expected) / std::abs(expected));
    }
    // Half a step's lag of the integration weighs most at a resonance: 1.7% where `ic` answers 3.3 times the tilt.
    CHECK(worst < 0.02);
  }
}

TEST_CASE("Family: independent channels are v = a - W f") {
  const BodyModel& model = independent_channels();
  const Coefficients c = model.family.coefficients(Parameters{1000.0, 300.0, 0.6, 0.02, 0.3, 0.15});
  CHECK(c[Coefficient::position] + c[Coefficient::gravity] == 1.0);
  CHECK(near(c[Coefficient::position] - c[Coefficient::tilt], 0.6, 1e-15));
  CHECK(near(c[Coefficient::tilt], 0.4, 1e-15));
  CHECK(c[Coefficient::theta] == 0.0);
}

TEST_CASE("body models: names, and protocols that name their controller") {
  for (const BodyModel* model : all_models()) {
    CHECK(&find_body_model(model->name, "test") == model);
    const Protocol read = protocol_from_json(to_json(with_model({}, *model)), "test");
    CHECK(read.experiment.body_model == model);
  }
  CHECK(!contains(to_json(default_protocol()), "controller"));
  check_error([] { find_body_model("pid", "--controller"); }, decid::Code::setting_unknown, "dec2015");
  const BodyModel same{.name = "dec", .parameters = single_pendulum().parameters};
  check_error([&] { register_body_model(same); }, decid::Code::setting_conflict, "dec");
  CHECK(single_pendulum().family.has_unit_gains());
  CHECK(!dec2015().family.has_unit_gains());
}
