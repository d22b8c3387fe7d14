// Simulation through C: the bits of the simulator, a row a trial.
#include "sim/simulate.hpp"

#include <cmath>

#include "sim/protocol/protocol_json.hpp"
#include "sim/streams.hpp"
#include "tests/bindings/c/owned.hpp"

namespace decid {

using namespace test;

TEST_CASE("trials have the bits of the simulator, alone and together") {
  const OwnedProtocol played = protocol("short");
  const sim::Simulator simulator(sim::short_protocol());
  const auto samples = static_cast<std::size_t>(simulator.samples());
  REQUIRE(decid_protocol_samples(played.get()) == samples);
  CHECK(decid_protocol_rate_hz(played.get()) == 100.0);
  CHECK(decid_protocol_json(played.get()) == sim::to_json(sim::short_protocol()));
  CHECK(decid_protocol_tilt(played.get())[300] == simulator.stimulus().tilt_at(3000));

  std::vector<double> parameters, sway_rad(3 * samples);
  for (int trial = 0; trial < 3; ++trial) {
    sim::Parameters own = sim::single_pendulum().parameters.middle();
    own[sim::Kp] += 10.0 * trial;
    parameters.insert(parameters.end(), own.begin(), own.end());
  }
  REQUIRE(decid_simulate(played.get(), parameters.data(), 3, 40, sway_rad.data(), nullptr) == DECID_OK);
  for (std::size_t trial = 0; trial < 3; ++trial) {
    sim::Parameters own = sim::single_pendulum().parameters.middle();
    own[sim::Kp] += 10.0 * static_cast<double>(trial);
    std::vector<double> expected(samples);
    REQUIRE(simulator.run(own, Random(40 + trial, sim::streams::vestibular_noise, 0), expected).valid);
    CHECK(
        std::equal(expected.begin(), expected.end(), sway_rad.begin() + static_cast<std::ptrdiff_t>(trial * samples)));
  }
}

TEST_CASE("controllers by name, with their own parameters") {
  REQUIRE(decid_controllers() >= 3);
  CHECK(decid_controller_name(0) == std::string("dec"));
  CHECK(!std::string(decid_controller_description(1)).empty());
  CHECK(decid_controller_name(1000) == nullptr);
  CHECK(decid_controller_description(1000) == nullptr);
  CHECK(decid_protocol_controller(nullptr) == nullptr);
  CHECK(decid_protocol_controller(protocol("short").get()) == std::string("dec"));
  for (std::size_t i = 0; i < decid_controllers(); ++i) {
    const std::string name = decid_controller_name(i);
    CAPTURE(name);
    const sim::BodyModel& model = sim::find_body_model(name, "test");
    if (model.family.terms.empty()) continue;
    const auto played = make<OwnedProtocol>(
        [&](decid_protocol** place) { return decid_protocol_load_controller("short", name.c_str(), place); });
    CHECK(decid_protocol_controller(played.get()) == name);
    REQUIRE(decid_protocol_parameters(played.get()) == model.parameters.size());
    CHECK(decid_protocol_parameter(played.get(), 2)->name == model.parameters[2].name);
    sim::Protocol expected = sim::short_protocol();
    expected.experiment.body_model = &model;
    const sim::Parameters middle = model.parameters.middle();
    std::vector<double> sway_rad(decid_protocol_samples(played.get())), simulated(sway_rad.size());
    REQUIRE(decid_simulate(played.get(), middle.begin(), 1, 5, sway_rad.data(), nullptr) == DECID_OK);
    sim::Simulator(expected).run(middle, Random(5, sim::streams::vestibular_noise, 0), simulated);
    CHECK(sway_rad == simulated);
  }
  decid_protocol* none = nullptr;
  refused(decid_protocol_load_controller("short", "pid", &none), Code::setting_unknown, "dec2015");
  refused(decid_protocol_load_controller(nullptr, "dec", &none), Code::setting_missing);
  CHECK(none == nullptr);
}

TEST_CASE("the protocol's sensor noise is added as data sets have it") {
  const TemporaryFolder folder;
  const auto path = write_text(folder / "noisy.json", R"({"sensor_noise_deg": 0.05})");
  const OwnedProtocol noisy = protocol(path.c_str());
  const sim::Parameters middle = sim::single_pendulum().parameters.middle();
  std::vector<double> sway_rad(decid_protocol_samples(noisy.get())), expected(sway_rad.size());
  REQUIRE(decid_simulate(noisy.get(), middle.begin(), 1, 5, sway_rad.data(), nullptr) == DECID_OK);
  sim::Protocol protocol = sim::default_protocol();
  protocol.noise.sensor = {0.05, 0.05};
  const sim::Simulator simulator(protocol);
  simulator.run(middle, Random(5, sim::streams::vestibular_noise, 0), expected);
  sim::record(protocol, 5, 0, expected);
  CHECK(sway_rad == expected);
}

TEST_CASE("a body that falls is an error, or a row that ends in NaN") {
  const OwnedProtocol played = protocol("default");
  sim::Parameters weak = sim::single_pendulum().parameters.middle();
  const sim::Parameters middle = weak;
  weak[sim::Kp] = weak[sim::Kp_pass] = 0.0;
  std::vector<double> parameters(middle.begin(), middle.end());
  parameters.insert(parameters.end(), weak.begin(), weak.end());
  const std::size_t samples = decid_protocol_samples(played.get());
  std::vector<double> sway_rad(2 * samples, 7.0);
  const std::vector<double> before = sway_rad;
  refused(decid_simulate(played.get(), parameters.data(), 2, 1, sway_rad.data(), nullptr), Code::body_falls,
          "decid_simulate");
  CHECK(sway_rad == before);
  unsigned char valid[2] = {7, 7};
  REQUIRE(decid_simulate(played.get(), parameters.data(), 2, 1, sway_rad.data(), valid) == DECID_OK);
  CHECK(valid[0] == 1);
  CHECK(valid[1] == 0);
  CHECK(std::isfinite(sway_rad[samples - 1]));
  CHECK(std::isfinite(sway_rad[samples]));
  CHECK(std::isnan(sway_rad.back()));
  parameters[0] = -1.0;
  refused(decid_simulate(played.get(), parameters.data(), 2, 1, sway_rad.data(), valid), Code::setting_out_of_range,
          "Kp");
  refused(decid_simulate(played.get(), nullptr, 2, 1, sway_rad.data(), valid), Code::setting_missing);
}

}  // namespace decid
