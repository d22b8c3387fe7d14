// The density of every model of the family: its sway against the simulator's, its gradient and its information against
// differences.
#include "posterior/density/density.hpp"
#include "tests/helpers.hpp"
#include "tests/posterior/density/density_points.hpp"
#include "tests/posterior/trial.hpp"
#include "tests/sim/third_model.hpp"

using namespace decid;
using namespace decid::posterior;
using namespace decid::test;

TEST_CASE("Density: the modelled sway of each model is the simulator's, with its noise") {
  for (const sim::BodyModel* body_model : all_models()) {
    CAPTURE(body_model->name);
    sim::Protocol protocol = with_model(sim::default_protocol(), *body_model);
    const Priors priors{.start_s = 0.0, .gain = 0.0, .standing_s = 0.0};
    protocol.noise.vestibular.period_s = Density(protocol, priors).noise_period_s();
    protocol.noise.vestibular.low_hz = 1.6 / protocol.noise.vestibular.period_s;
    const Density density(protocol, priors);
    const std::vector<double> unit(body_model->parameters.size(), 0.35);
    const sim::Parameters parameters = body_model->parameters.from_unit(unit);
    const Observation observation = density.observe(recorded(protocol, parameters, 0.0, 4));
    Values x(static_cast<std::size_t>(density.size()) * lanes, 0.0);
    for (int chain = 0; chain < lanes; ++chain)
      density.set({.parameters = parameters, .sensor_noise_deg = 0.02}, x, chain);
    set_simulated_noise(density, body_model->family.coefficients(parameters)[sim::Coefficient::nv], 4, x);
    const Modelled modelled = model(density, observation, x);
    for (std::size_t m = 0; m < static_cast<std::size_t>(density.blocks()); ++m) {
      CHECK(modelled.sway[m * lanes] == modelled.sway[m * lanes + 5]);
      const double line =
          observation.level_rad + observation.slope_rad * (static_cast<double>(m) - 0.5 * (density.blocks() - 1));
      REQUIRE(within(modelled.sway[m * lanes] + modelled.residual[m * lanes], observation.sway[m] + line, 1e-15));
    }
    CHECK(rms_deg(observation.sway) > 0.1);
    // A measurement noise of 0.02 degrees leaves 6e-3 in a block.
    CHECK(rms_deg(of_chain(modelled.residual, 0)) < 1e-3);
  }
}

TEST_CASE("Density: the gradient of each model is that of its potential") {
  for (const sim::BodyModel* body_model : all_models()) {
    CAPTURE(body_model->name);
    const sim::Protocol protocol = with_model(sines_protocol(), *body_model);
    const std::string first = body_model->parameters[0].name, second = body_model->parameters[2].name;
    const sim::ParameterInfo& info = body_model->parameters[2];
    for (const Priors& priors :
         {Priors{}, Priors{.parameters = {{.name = first, .fixed = body_model->parameters[0].middle()},
                                          {.name = second,
                                          .normal = ParameterPrior::Normal{info.middle(), 0.2 * info.range()}}}}}) {
      const Density density(protocol, priors);
      const Observation observation = density.observe(recorded(protocol, body_model->parameters.middle(), 0.02, 0));
      CHECK(worst_gradient(density, observation, {}) < 1.0);
    }
  }
}

TEST_CASE("Density: a fixed parameter keeps its value and is not inferred") {
  const Density density(sines_protocol(), {.parameters = {{.name = "Kd", .fixed = 250.0}}});
  CHECK(!density.infers(sim::Kd));
  CHECK(density.infers(sim::Kp));
  const Values x = random_points(density, 5);
  for (int chain = 0; chain < lanes; ++chain) CHECK(density.state(x, chain).parameters[sim::Kd] == 250.0);
  CHECK(density.prior_coordinate(sim::Kd, density.state(x, 0)) == 0.0);
  const auto with = [](const ParameterPrior& prior) {
    return [prior] { Density(sines_protocol(), {.parameters = {prior}}); };
  };
  check_error(with({.name = "delay", .fixed = 1.5}), Code::setting_out_of_range, "1.5");
  check_error(with({.name = "Kd", .fixed = -1.0}), Code::setting_out_of_range, "Kd");
  check_error(with({.name = "Kd", .range = ParameterPrior::Range{1.0, 2.0}, .fixed = 1.5}), Code::setting_conflict,
              "Kd");
}

TEST_CASE("Density: a body model whose threshold shares a parameter is refused") {
  sim::BodyModel model = third_model();
  model.family.terms.push_back({6, sim::Coefficient::slow, 1.0});
  check_error([&] { Density(with_model(sines_protocol(), model), {}); }, Code::not_supported, "third");
}

TEST_CASE("Density: the information of each model is that of its derivatives") {
  for (const sim::BodyModel* body_model : all_models()) {
    CAPTURE(body_model->name);
    const sim::Protocol protocol = with_model(sines_protocol(), *body_model);
    const Density density(protocol, {});
    const Observation observation = density.observe(recorded(protocol, body_model->parameters.middle(), 0.02, 0));
    const Values x = random_points(density, 2);
    const int noises = density.noise_size();
    std::vector<int> some{0, noises - 1};
    for (int i = 0; i < density.parameters(); ++i) some.push_back(noises + i);
    CHECK(worst_information(density, observation, x, some, 3) < 4e-4);
  }
}
