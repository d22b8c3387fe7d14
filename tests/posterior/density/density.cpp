// The density of a recorded trial: its sway against the simulator's, its gradient against finite differences, the same
// bits for every instruction set.
#include "posterior/density/density.hpp"

#include <algorithm>
#include <array>
#include <complex>
#include <limits>
#include <numeric>
#include <variant>

#include "base/math/cholesky.hpp"
#include "base/text.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"
#include "tests/posterior/density/density_points.hpp"
#include "tests/posterior/trial.hpp"

using namespace decid;
using namespace decid::posterior;
using namespace decid::test;

namespace {

/// Subtracts the least-squares line, as the model fits the offset and the drift.
std::vector<double> without_line(std::vector<double> values) {
  const auto count = static_cast<double>(values.size());
  double mean = 0.0, slope = 0.0, squares = 0.0;
  const auto place = [&](std::size_t i) { return static_cast<double>(i) - 0.5 * (count - 1.0); };
  for (std::size_t i = 0; i < values.size(); ++i) {
    mean += values[i] / count;
    slope += place(i) * values[i];
    squares += place(i) * place(i);
  }
  for (std::size_t i = 0; i < values.size(); ++i) values[i] -= mean + slope / squares * place(i);
  return values;
}

}  // namespace

TEST_CASE("Density: the gradient is that of the potential") {
  const sim::Protocol protocol = sines_protocol();
  for (const Priors& priors : {Priors{}, Priors{.standing_s = 0.0}, Priors{.parameters = parameter_priors()},
                               Priors{.standing_s = 3.0, .moved_before = true}}) {
    const Density density(protocol, priors);
    const Observation observation = density.observe(recorded(protocol, some_parameters(), 0.02, 0));
    CHECK(worst_gradient(density, observation, {}) < 1.0);
    if (priors.parameters.empty() && !priors.moved_before) CHECK(worst_gradient(density, observation, 0.1) < 1.0);
  }
}

TEST_CASE("Density: the gradient where start and gain are known, and without vestibular noise") {
  sim::Protocol protocol = sines_protocol();
  protocol.noise.vestibular.scale_deg = 0.0;
  const Density density(protocol, {.start_s = 0.0, .gain = 0.0, .standing_s = 0.0});
  CHECK(density.noise_size() == 0);
  const Observation observation = density.observe(recorded(protocol, some_parameters(), 0.02, 0));
  CHECK(worst_gradient(density, observation, {}) < 1.0);
  const Values x = random_points(density, 1);
  const State state = density.state(x, 3);
  CHECK(state.start_s == 0.0);
  CHECK(state.gain == 1.0);
}

namespace {

/// A trial that begins with 10 s of rest, of which they are cut away: the body sways when the recording begins.
struct Standing {
  sim::Protocol protocol;
  Priors priors{.start_s = 0.0, .gain = 0.0, .standing_s = 10.0};
  sim::Parameters parameters = some_parameters();
  std::vector<float> sway;
  Density density;
  Values x;

  explicit Standing(const sim::Protocol& of)
      : protocol(of), sway(cut()), density(protocol, priors), x(static_cast<std::size_t>(density.size()) * lanes, 0.0) {
    for (int chain = 0; chain < lanes; ++chain)
      density.set({.parameters = parameters, .sensor_noise_deg = 0.02}, x, chain);
    set_simulated_noise(density, parameters[sim::Nv], 4, x);
  }
  std::vector<float> cut() {
    protocol.noise.vestibular.period_s = Density(protocol, priors).noise_period_s();
    protocol.noise.vestibular.low_hz = 1.6 / protocol.noise.vestibular.period_s;
    sim::Protocol whole = protocol;
    std::visit([](auto& kind) { kind.lead_in_s += 10.0; }, whole.experiment.stimulus);
    const std::vector<float> all = recorded(whole, parameters, 0.0, 4);
    return {all.end() - protocol.samples(), all.end()};
  }
};

sim::Protocol one_sequence() {
  sim::Protocol protocol = sim::default_protocol();
  std::get<sim::Sequence>(protocol.experiment.stimulus).cycles = 1;
  return protocol;
}

}  // namespace

TEST_CASE("Density: a body that has stood and swayed before the recording is modelled") {
  for (const sim::Protocol& protocol : {sines_protocol(), one_sequence()}) {
    const Standing standing(protocol);
    const Observation observation = standing.density.observe(standing.sway);
    CHECK(rms_deg(observation.sway) > 0.1);
    CHECK(rms_deg(of_chain(model(standing.density, observation, standing.x).residual, 0)) < 1e-3);
    // A body at rest is another.
    const Density at_rest(standing.protocol, {.start_s = 0.0, .gain = 0.0, .standing_s = 0.0});
    Values x(static_cast<std::size_t>(at_rest.size()) * lanes, 0.0);
    for (int chain = 0; chain < lanes; ++chain)
      at_rest.set({.parameters = standing.parameters, .sensor_noise_deg = 0.02}, x, chain);
    CHECK(rms_deg(of_chain(model(at_rest, at_rest.observe(standing.sway), x).residual, 0)) > 0.02);
  }
}

// With bins of 100 ms alone the residuals are 0.002 and 0.003 degrees.
TEST_CASE("Density: a platform that moves far, and at other times than a bin's, is modelled as well") {
  for (const double state_s : {0.25, 0.24}) {  // in 10 s of standing there are whole bins of 100 and of 80 ms
    sim::Protocol protocol = sim::short_protocol();
    sim::Sequence& sequence = std::get<sim::Sequence>(protocol.experiment.stimulus);
    sequence.amplitude_deg = 4.0;
    sequence.state_s = state_s;
    sequence.cycles = 1;
    const Standing standing(protocol);
    const Observation observation = standing.density.observe(standing.sway);
    CHECK(rms_deg(of_chain(model(standing.density, observation, standing.x).residual, 0)) < 6e-4);
    CHECK(within(standing.density.block_s(), state_s == 0.25 ? 0.1 : 0.08, 1e-9));
  }
}

TEST_CASE("Density: a platform that never passes the dead band is modelled as well") {
  sim::Protocol protocol = sines_protocol();
  for (sim::Sine& sine : std::get<sim::Sines>(protocol.experiment.stimulus).components)
    sine.amplitude_deg *= 0.1;  // at most 0.0018 rad/s together
  protocol.noise.vestibular.scale_deg = 0.0;
  sim::Parameters parameters = some_parameters();
  parameters[sim::Theta] = 0.005;
  const Density density(protocol, {.start_s = 0.0, .gain = 0.0, .standing_s = 0.0});
  Values x(static_cast<std::size_t>(density.size()) * lanes, 0.0);
  for (int chain = 0; chain < lanes; ++chain)
    density.set({.parameters = parameters, .sensor_noise_deg = 0.02}, x, chain);
  const Observation observation = density.observe(recorded(protocol, parameters, 0.0, 0));
  CHECK(rms_deg(of_chain(model(density, observation, x).residual, 0)) < 2e-4);
}

TEST_CASE("Density: blocks that align are not longer than a short protocol allows") {
  sim::Protocol protocol = sim::short_protocol();
  protocol.experiment.stimulus = sim::Sequence{
      .feedback = {1, 2}, .start = {1, 1}, .state_s = 0.33, .offset_s = 0.0, .cycles = 1, .lead_out_s = 0.1};
  const Density density(protocol, {});
  CHECK(density.blocks() >= 20);
  CHECK(within(density.block_s(), 0.1, 1e-9));
}

TEST_CASE("Density: before the trial the platform rested, or it played the end of the cycle") {
  sim::Protocol twice = sines_protocol();
  std::get<sim::Sines>(twice.experiment.stimulus).cycles = 2;
  twice.noise.vestibular.scale_deg = twice.noise.vestibular.period_s = 0.0;
  sim::Protocol once = sines_protocol();
  once.noise.vestibular.scale_deg = 0.0;
  const std::vector<float> both = recorded(twice, some_parameters(), 0.0, 0);
  const std::vector<float> second(both.end() - once.samples(), both.end());
  for (const bool moved : {true, false}) {
    const Density density(once, {.start_s = 0.0, .gain = 0.0, .standing_s = 20.0, .moved_before = moved});
    Values x(static_cast<std::size_t>(density.size()) * lanes, 0.0);
    for (int chain = 0; chain < lanes; ++chain)
      density.set({.parameters = some_parameters(), .sensor_noise_deg = 0.02}, x, chain);
    const double error = rms_deg(of_chain(model(density, density.observe(second), x).residual, 0));
    CHECK((error < 1e-3) == moved);
    CHECK((error > 3e-3) == !moved);
  }
}

// Samples are floats: 0.3 degrees of offset move them by up to 2e-10 rad.
TEST_CASE("Density: an offset and a straight line change nothing") {
  const Standing standing(sines_protocol());
  std::vector<float> noisy = standing.sway, moved;
  std::vector<double> noise(noisy.size());
  Random(5, sim::streams::sensor_noise, 4).fill_normal(noise);
  for (std::size_t i = 0; i < noisy.size(); ++i) {
    const double value = double{noisy[i]} + 0.02 * sim::rad_per_deg * noise[i];
    const double place = static_cast<double>(i) / static_cast<double>(noisy.size());
    noisy[i] = static_cast<float>(value);
    moved.push_back(static_cast<float>(value + (0.3 + 0.4 * place) * sim::rad_per_deg));
  }
  const Density& density = standing.density;
  const Observation here = density.observe(noisy), there = density.observe(moved);
  CHECK(within((there.level_rad - here.level_rad) / sim::rad_per_deg, 0.5, 1e-3));
  CHECK(within((there.slope_rad - here.slope_rad) * density.blocks() / sim::rad_per_deg, 0.4, 1e-6));
  for (std::size_t m = 0; m < here.sway.size(); ++m) REQUIRE(within(there.sway[m], here.sway[m], 1e-9));
  const Evaluated before = evaluate(density, here, standing.x), after = evaluate(density, there, standing.x);
  for (std::size_t l = 0; l < lanes; ++l) CHECK(near(after.potential[l], before.potential[l], 1e-6));
  double largest = 0.0;
  for (const double value : before.gradient) largest = std::max(largest, std::abs(value));
  for (std::size_t i = 0; i < before.gradient.size(); ++i)
    REQUIRE(within(after.gradient[i], before.gradient[i], 1e-6 * largest));
  const Modelled modelled = model(density, here, standing.x), shifted = model(density, there, standing.x);
  for (std::size_t m = 0; m < here.sway.size(); ++m) {
    const double place = (static_cast<double>(m) + 0.5) / density.blocks();
    REQUIRE(within((shifted.sway[m * lanes] - modelled.sway[m * lanes]) / sim::rad_per_deg, 0.3 + 0.4 * place, 1e-3));
  }
}

// Without what observe() takes away: the priors of offset and line are 10 degrees, so of the noise's size 1e-6.
TEST_CASE("Density: an offset and a line that the observation still has are integrated out") {
  const Standing standing(sines_protocol());
  const Density& density = standing.density;
  const Observation here = density.observe(standing.sway);
  Observation there = here;
  for (std::size_t m = 0; m < there.sway.size(); ++m)
    there.sway[m] += (0.3 + 0.4 * static_cast<double>(m) / density.blocks()) * sim::rad_per_deg;
  const Evaluated before = evaluate(density, here, standing.x), after = evaluate(density, there, standing.x);
  // Half of the squares of offset and line in units of their priors; the model has an offset of less than a degree.
  for (std::size_t l = 0; l < lanes; ++l)
    CHECK(within(after.potential[l], before.potential[l], 0.5 * (0.05 * 0.15 + 0.04 * 0.14)));
  double largest = 0.0;
  for (const double value : before.gradient) largest = std::max(largest, std::abs(value));
  for (std::size_t i = 0; i < before.gradient.size(); ++i)
    REQUIRE(within(after.gradient[i], before.gradient[i], 1e-5 * largest));
}

// The noise is wide, so rounding of the explicit matrices is small. The residual has no offset and line. With priors of
// 10 degrees, an offset of 3 degrees adds 0.045, and a line of 3 degrees at most 0.09.
TEST_CASE("Density: the potential is the misfit of the explicit noise and of the priors") {
  const sim::Protocol protocol = sines_protocol();
  const Density density(protocol, {});
  const Observation observation = density.observe(recorded(protocol, some_parameters(), 0.02, 0));
  Values x = random_points(density, 6);
  for (int chain = 0; chain < lanes; ++chain) density.set_noise(1.0, 0.5, x, chain);
  const Evaluated all = evaluate(density, observation, x);
  const Values residual = model(density, observation, x).residual;
  const std::size_t kept = coefficients(density);
  for (std::size_t l = 0; l < lanes; ++l) {
    const State state = density.state(x, static_cast<int>(l));
    const DenseNoise noise = noise_of(density, state);
    const double misfit = noise.of_coefficients(kept).misfit(noise.transform(kept, of_chain(residual, l)));
    const double variance = state.parameters[sim::Nv] * state.parameters[sim::Nv] + 0.05 * 0.05;
    double prior = 0.5 * density.noise_size() * std::log(variance);
    for (int i = 0; i < density.size(); ++i)
      prior += 0.5 * at(x, i, l) * at(x, i, l) / (i < density.noise_size() ? variance : 1.0);
    CHECK(within(all.potential[l], misfit + prior, 0.15));
  }
}

// Given all others a block is normal with the precision Q_ii and the mean r_i - (Q r)_i / Q_ii.
TEST_CASE("Density: a block given all others, by the explicit inverse covariance") {
  const sim::Protocol protocol = sines_protocol();
  const Density density(protocol, {});
  const Observation observation = density.observe(recorded(protocol, some_parameters(), 0.02, 0));
  const Values x = random_points(density, 7);
  const auto blocks = static_cast<std::size_t>(density.blocks());
  std::vector<double> log_density(blocks * lanes), few(blocks);
  Density::Workspace work(density);
  density.leave_block_out(observation, x, log_density, work);
  CHECK_THROWS_AS(density.leave_block_out(observation, x, few, work), Error);
  const Modelled modelled = model(density, observation, x);
  const std::size_t kept = coefficients(density);
  for (std::size_t l = 0; l < lanes; l += 3) {
    const DenseNoise noise = noise_of(density, density.state(x, static_cast<int>(l)));
    const DenseGaussian gaussian = noise.of_coefficients(kept);
    const std::vector<double> residual = gaussian.whitened(noise.transform(kept, of_chain(modelled.residual, l)));
    for (std::size_t i = 0; i < blocks; ++i) {
      std::vector<double> unit(blocks, 0.0);
      unit[i] = 1.0;
      const std::vector<double> column = gaussian.whitened(noise.transform(kept, unit));
      double precision = 0.0, weighed = 0.0;
      for (std::size_t k = 0; k < kept; ++k) precision += column[k] * column[k], weighed += column[k] * residual[k];
      const double square = weighed * weighed / precision;
      const double expected = 0.5 * std::log(precision / (2.0 * sim::pi)) - 0.5 * square + std::log(sim::rad_per_deg);
      // The residual's line is fitted, with a prior that is not quite flat.
      CHECK(within(log_density[i * lanes + l], expected, (1e-5 + 10.0 * noise.rounding(kept)) * (1.0 + square)));
    }
  }
}

TEST_CASE("Density: the same bits for every instruction set, and beside any other chains") {
  const sim::Protocol protocol = sines_protocol();
  const Density density(protocol, {});
  const std::vector<float> sway = recorded(protocol, some_parameters(), 0.02, 0);
  Values x = random_points(density, 1);
  const Evaluated first = evaluate(density, density.observe(sway), x);
  std::vector<double> information(triangle(static_cast<std::size_t>(density.size())) * lanes);
  Density::Workspace first_work(density);
  density.information(density.observe(sway), x, information, first_work);
  for (const Isa isa : available_isas()) {
    const Density other(protocol, {}, isa);
    const Evaluated again = evaluate(other, other.observe(sway), x);
    CHECK(again.potential == first.potential);
    CHECK(again.gradient == first.gradient);
    std::vector<double> matrices(information.size());
    Density::Workspace work(other);
    other.information(other.observe(sway), x, matrices, work);
    CHECK(matrices == information);
  }
  for (int i = 0; i < density.size(); ++i)
    for (std::size_t l = 1; l < lanes; ++l) at(x, i, l) = 0.0;
  const Evaluated alone = evaluate(density, density.observe(sway), x);
  CHECK(alone.potential[0] == first.potential[0]);
  for (std::size_t i = 0; i < x.size(); i += lanes) REQUIRE(alone.gradient[i] == first.gradient[i]);
}

TEST_CASE("Density: a start is a shift of the modelled sway, a gain its factor") {
  const sim::Protocol protocol = sines_protocol();
  const Density density(protocol, {});
  const Observation observation = density.observe(recorded(protocol, some_parameters(), 0.02, 0));
  Values x(static_cast<std::size_t>(density.size()) * lanes, 0.0);
  const double block_s = 0.1;
  const std::array<State, 3> states{State{some_parameters(), 0.02, 0.0, 1.0}, State{some_parameters(), 0.02, 0.09, 1.0},
                                    State{some_parameters(), 0.02, 0.0, 0.93}};
  for (int chain = 0; chain < lanes; ++chain) density.set(states[static_cast<std::size_t>(chain % 3)], x, chain);
  // Offset and line of each chain are fitted to what it leaves of the recording.
  const Values modelled = model(density, observation, x).sway;
  const std::vector<double> plain = of_chain(modelled, 0), later = of_chain(modelled, 1), less = of_chain(modelled, 2);
  std::vector<double> of_start, of_gain;
  for (std::size_t m = 20; m + 2 < plain.size(); ++m) {
    // Cubic interpolation of the blocks at 0.9 of one to the next.
    const double t = 0.09 / block_s;
    const double between = -t * (t - 1) * (t - 2) / 6 * plain[m - 1] + (t + 1) * (t - 1) * (t - 2) / 2 * plain[m] -
                           (t + 1) * t * (t - 2) / 2 * plain[m + 1] + (t + 1) * t * (t - 1) / 6 * plain[m + 2];
    of_start.push_back(later[m] - between);
    of_gain.push_back(less[m] - 0.93 * plain[m]);
  }
  const double sway_deg = rms_deg(without_line(plain));
  CHECK(sway_deg > 0.1);
  CHECK(rms_deg(without_line(of_start)) < 1e-3 * sway_deg);
  CHECK(rms_deg(without_line(of_gain)) < 1e-12 * sway_deg);
}

TEST_CASE("Density: errors") {
  sim::Protocol protocol = sines_protocol();
  const Density density(protocol, {});
  check_error([&] { density.observe(std::vector<float>(1999)); }, Code::size_mismatch, "1999 samples");
  protocol.experiment.stimulus =
      sim::Sines{.components = {{.frequency_hz = 0.6, .amplitude_deg = 0.7}}, .cycle_s = 1.9};
  protocol.noise.vestibular.low_hz = 0.5;
  check_error([&] { Density short_one(protocol, {}); }, Code::setting_out_of_range, "1.9 s");
  for (const double cycle_s : {0.05, 0.09, 0.1}) {
    sim::Protocol tiny = protocol;
    tiny.noise.vestibular.period_s = 3.0;
    tiny.experiment.stimulus =
        sim::Sines{.components = {{.frequency_hz = 5.0, .amplitude_deg = 0.1}}, .cycle_s = cycle_s};
    check_error([&] { Density none(tiny, {}); }, Code::setting_out_of_range, format("lasts %g s", cycle_s));
  }
  protocol = sines_protocol();
  protocol.noise.vestibular.low_hz = protocol.noise.vestibular.high_hz = 0.1;
  check_error([&] { Density one_line(protocol, {}); }, Code::setting_out_of_range, "single frequency");
  protocol.noise.vestibular = {.low_hz = 0.005, .high_hz = 0.006, .period_s = 2000.0};
  check_error([&] { Density too_slow(protocol, {}); }, Code::setting_out_of_range, "0.006 Hz");
  protocol.noise.vestibular = {.high_hz = max_noise_hz};
  CHECK(Density(protocol, {}).noise_size() > 0);
  protocol.noise.vestibular.high_hz = 5.0;
  check_error([&] { Density too_fast(protocol, {}); }, Code::not_supported, "5 Hz");
  protocol.noise.vestibular.scale_deg = 0.0;
  CHECK(Density(protocol, {}).noise_size() == 0);
  check_error([&] { Density(sines_protocol(), {.start_s = 1.1}); }, Code::setting_out_of_range);  // see priors.cpp

  const Observation observation = density.observe(recorded(sines_protocol(), some_parameters(), 0.02, 0));
  Density::Workspace work(density);
  const auto size = static_cast<std::size_t>(density.size());
  Values x(size * lanes), gradient(size * lanes), few(size), blocks(static_cast<std::size_t>(density.blocks()) * lanes);
  std::vector<double> potential(lanes);
  CHECK_THROWS_AS(density.evaluate(observation, few, gradient, potential, work), Error);
  CHECK_THROWS_AS(density.evaluate(observation, x, few, potential, work), Error);
  CHECK_THROWS_AS(density.evaluate({}, x, gradient, potential, work), Error);
  CHECK_THROWS_AS(density.model(observation, x, blocks, few, work), Error);
  CHECK_THROWS_AS(density.information(observation, x, few, work), Error);

  protocol = sines_protocol();
  protocol.experiment.body.mass_kg = -1.0;
  CHECK_THROWS_AS(Density(protocol, {}), Error);
}
