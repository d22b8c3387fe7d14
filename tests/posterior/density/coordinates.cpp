// Coordinates of a density and the states that they stand for, under the priors.
#include <algorithm>

#include "posterior/density/density.hpp"
#include "tests/helpers.hpp"
#include "tests/posterior/density/density_points.hpp"
#include "tests/posterior/trial.hpp"

using namespace decid;
using namespace decid::posterior;
using namespace decid::test;

TEST_CASE("Density: states are set and read, those outside of the ranges at their edge") {
  const Density density(sines_protocol(), {});
  Values x(static_cast<std::size_t>(density.size()) * lanes, 0.0);
  State state{.parameters = some_parameters(),
              .sensor_noise_deg = 0.05,
              .start_s = 0.03,
              .gain = 0.95,
              .slow_noise_deg = 0.03,
              .slow_memory_s = 2.0};
  density.set(state, x, 2);
  const State back = density.state(x, 2);
  for (std::size_t i = 0; i < state.parameters.size(); ++i) CHECK(near(back.parameters[i], state.parameters[i], 1e-12));
  CHECK(near(back.sensor_noise_deg, 0.05, 1e-12));
  CHECK(near(back.start_s, 0.03, 1e-12));
  CHECK(near(back.gain, 0.95, 1e-12));
  CHECK(near(back.slow_noise_deg, 0.03, 1e-12));
  CHECK(near(back.slow_memory_s, 2.0, 1e-12));
  for (std::size_t place = 0; place < static_cast<std::size_t>(density.globals()); ++place) {
    CAPTURE(place);
    CHECK(density.prior_coordinate(density.quantity(place), state) ==
          x[(static_cast<std::size_t>(density.noise_size()) + place) * lanes + 2]);
  }
  density.set_noise(0.01, 0.002, x, 2);
  CHECK(near(density.state(x, 2).sensor_noise_deg, 0.01, 1e-12));
  CHECK(near(density.state(x, 2).slow_noise_deg, 0.002, 1e-12));
  CHECK(density.state(x, 2).parameters == back.parameters);
  state.parameters[sim::Kp] = 1e9;
  density.set(state, x, 2);
  const sim::ParameterInfo& info = density.protocol().parameters()[sim::Kp];
  CHECK(near(density.state(x, 2).parameters[sim::Kp], info.low + 0.99 * info.range(), 1e-12));
}

TEST_CASE("Density: parameters lie where their priors say") {
  const Density density(sines_protocol(), {.parameters = parameter_priors()});
  CHECK(density.ranges()[sim::Kp].low == 700.0);
  CHECK(density.ranges()[sim::Kp].high == 1000.0);
  CHECK(density.ranges()[sim::Nv].high == 0.6);
  CHECK(density.ranges()[sim::Kd].high == density.protocol().parameters()[sim::Kd].high);
  Values x(static_cast<std::size_t>(density.size()) * lanes, 0.0);
  CHECK(near(density.state(x, 0).parameters[sim::Nv], 0.35, 1e-12));
  for (const double coordinate : {-30.0, 30.0}) {
    std::ranges::fill(x, coordinate);
    const State state = density.state(x, 0);
    CHECK(near(state.parameters[sim::Kp], coordinate < 0.0 ? 700.0 : 1000.0, 1e-6));
    CHECK(near(state.parameters[sim::Nv], coordinate < 0.0 ? 0.1 : 0.6, 1e-12));
  }
  // The quartiles of a normal distribution that its range does not cut.
  const Density wide(sines_protocol(), {.parameters = {{.name = "Kp", .normal = ParameterPrior::Normal{900.0, 20.0}}}});
  Values y(static_cast<std::size_t>(wide.size()) * lanes, 0.6);
  CHECK(near(wide.state(y, 0).parameters[sim::Kp], 912.0, 1e-12));
}

TEST_CASE("Density: the last globals, those of the slow noise, are held") {
  const Density density(sines_protocol(), {});
  CHECK(density.globals() == 12);
  for (std::size_t place = 0; place < 12; ++place) {
    const int quantity = density.quantity(place);
    CHECK(density.place(quantity) == place);
    CHECK(density.is_held(place) == (quantity == Density::slow_noise || quantity == Density::slow_memory));
  }
}
