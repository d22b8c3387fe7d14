#include "posterior/frf/stability.hpp"

#include <cmath>

#include "base/math/random.hpp"
#include "sim/body_model.hpp"
#include "sim/simulate.hpp"
#include "tests/helpers.hpp"
#include "tests/sim/run.hpp"
#include "tests/sim/third_model.hpp"

using namespace decid;
using namespace decid::test;

TEST_CASE("unstable roots are counted without delay and with") {
  CHECK(frf::unstable_roots({6.0, -7.0, 0.0, 1.0}, {0.0}, 0.1) == 2);           // (s - 1) (s - 2) (s + 3)
  CHECK(frf::unstable_roots({6.0, 11.0, 6.0, 1.0}, {0.0}, 0.1) == 0);           // (s + 1) (s + 2) (s + 3)
  CHECK(frf::unstable_roots({24.0, 14.0, -13.0, -2.0, 1.0}, {0.0}, 0.1) == 2);  // (s + 1) (s - 2) (s + 3) (s - 4)
  // s + exp(-s delay): pairs cross at pi / 2, 5 pi / 2, ...
  CHECK(frf::unstable_roots({0.0, 1.0}, {1.0}, 0.0) == 0);
  CHECK(frf::unstable_roots({0.0, 1.0}, {1.0}, 1.57) == 0);
  CHECK(frf::unstable_roots({0.0, 1.0}, {1.0}, 1.58) == 2);
  CHECK(frf::unstable_roots({0.0, 1.0}, {1.0}, 7.85) == 2);
  CHECK(frf::unstable_roots({0.0, 1.0}, {1.0}, 7.86) == 4);
}

TEST_CASE("a loop with unit gains has the count's stability") {
  sim::Family general = sim::single_pendulum().family;
  general.terms.push_back({sim::Nv, sim::Coefficient::slow, 0.0});  // no effect, and no closed form
  REQUIRE_FALSE(general.has_unit_gains());
  const sim::Family& family = sim::single_pendulum().family;
  int stable = 0;
  constexpr int loops = 3000;
  for (unsigned i = 0; i < loops; ++i) {
    const Random random(3, sim::streams::base_parameters, i);
    std::vector<double> unit;
    for (std::size_t p = 0; p < 7; ++p) unit.push_back(1.4 * random.uniform(p) - 0.2);
    unit[sim::Delay] = std::abs(unit[sim::Delay]);
    const sim::Coefficients c = family.coefficients(sim::single_pendulum().parameters.from_unit(unit));
    const bool closed_form = frf::is_stable(sim::Body{}, family, c);
    stable += closed_form ? 1 : 0;
    CHECK(frf::is_stable(sim::Body{}, general, c) == closed_form);
  }
  CHECK(stable > loops / 3);
  CHECK(stable < loops - loops / 20);
}

// A slow root near 0 leaves no trace in a trial of a minute: one in thirty loops may differ.
TEST_CASE("stability is the simulator's for every model") {
  for (const sim::BodyModel* model : {&sim::dec2015(), &sim::independent_channels(), &third_model()}) {
    CAPTURE(model->name);
    sim::Protocol quiet = with_model(sim::default_protocol(), *model);
    quiet.noise.vestibular.scale_deg = 0.0;
    quiet.sequence().amplitude_deg = 0.01;
    const sim::Simulator simulator(quiet);
    std::vector<double> sway(static_cast<std::size_t>(quiet.samples()));
    int stable = 0, unstable = 0, differ = 0;
    for (unsigned i = 0; i < 150; ++i) {
      const Random random(9, sim::streams::base_parameters, i);
      std::vector<double> unit;
      for (std::size_t p = 0; p < model->parameters.size(); ++p) unit.push_back(random.uniform(p));
      const sim::Parameters parameters = model->parameters.from_unit(unit);
      const auto is_stable = [&](double factor) {
        sim::Coefficients c = model->family.coefficients(parameters);
        c[sim::Coefficient::delay] *= factor;
        return frf::is_stable(quiet.experiment.body, model->family, c);
      };
      if (is_stable(0.9) != is_stable(1.1)) continue;  // grows too slowly to show
      (is_stable(1.0) ? stable : unstable)++;
      differ += simulator.run(parameters, random, sway).valid != is_stable(1.0) ? 1 : 0;
    }
    MESSAGE(model->name << ": " << stable << " stable, " << unstable << " unstable, " << differ << " differ");
    CHECK(stable > 20);
    CHECK(differ <= 5);
  }
}
