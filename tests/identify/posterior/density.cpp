// The density of a recorded trial: its sway against the simulator's, its gradient against finite differences, its
// information against products of differences, the same bits for every instruction set.
#include "identify/posterior/density.hpp"

#include <algorithm>
#include <array>
#include <complex>
#include <limits>

#include "identify/posterior/cholesky.hpp"
#include "tests/helpers.hpp"
#include "tests/identify/posterior/trial.hpp"

using namespace decid;
using namespace decid::posterior;
using namespace decid::test;

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

using Values = AlignedVector<double>;

/// Eight chains at different places.
Values random_points(const Density& density, std::uint64_t item) {
  Values x(static_cast<std::size_t>(density.size()) * lanes);
  Random(3, Stream::posterior, item).fill_normal(x);
  for (double& value : x) value *= 0.5;
  return x;
}

double& at(Values& x, int coordinate, std::size_t chain) {
  return x[static_cast<std::size_t>(coordinate) * lanes + chain];
}

struct Evaluated {
  Values gradient;
  std::vector<double> potential;
};
Evaluated evaluate(const Density& density, const Observation& observation, const Values& x,
                   std::optional<double> fixed_noise_deg = {}) {
  Density::Workspace work(density);
  Evaluated result{Values(x.size()), std::vector<double>(lanes)};
  density.evaluate(observation, x, result.gradient, result.potential, work, fixed_noise_deg);
  return result;
}

/// The largest difference of the gradient from a central difference of the potential, over what rounding and the
/// third derivative allow.
double worst_gradient(const Density& density, const Observation& observation, std::optional<double> fixed_noise_deg) {
  const Values x = random_points(density, 1);
  const Evaluated here = evaluate(density, observation, x, fixed_noise_deg);
  double worst = 0.0;
  for (int i = 0; i < density.size(); ++i) {
    // Steps at which the two errors are alike: the cube root of epsilon.
    const double step = 6e-6;
    Values high = x, low = x;
    for (std::size_t l = 0; l < lanes; ++l) at(high, i, l) += step, at(low, i, l) -= step;
    const Evaluated above = evaluate(density, observation, high, fixed_noise_deg);
    const Evaluated below = evaluate(density, observation, low, fixed_noise_deg);
    for (std::size_t l = 0; l < lanes; ++l) {
      const double difference = (above.potential[l] - below.potential[l]) / (2.0 * step);
      const double gradient = here.gradient[static_cast<std::size_t>(i) * lanes + l];
      const double curvature = std::abs(here.potential[l]);  // second and third derivatives are of the potential's size
      const double allowed = 100.0 * (epsilon * curvature / step + step * step * curvature) + 1e-6 * std::abs(gradient);
      worst = std::max(worst, std::abs(difference - gradient) / allowed);
    }
  }
  return worst;
}

}  // namespace

TEST_CASE("Density: the gradient is that of the potential") {
  const sim::Protocol protocol = sines_protocol();
  const Density density(protocol, {});
  const Observation observation = density.observe(recorded(protocol, some_parameters(), 0.02, 0));
  CHECK(worst_gradient(density, observation, {}) < 1.0);
  CHECK(worst_gradient(density, observation, 0.1) < 1.0);
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

TEST_CASE("Density: the modelled sway is the simulator's, with its noise") {
  // The basis' own period, so that the simulator's noise is one of the basis.
  sim::Protocol protocol = sim::default_protocol();
  protocol.noise.vestibular.period_s = Density(protocol, {}).noise_period_s();
  const double period_s = protocol.noise.vestibular.period_s;
  protocol.noise.vestibular.low_hz = 1.6 / period_s;  // the basis' harmonic 2 stands for 1.5 to 2.5
  const Density density(protocol, {.start_s = 0.0, .gain = 0.0, .standing_s = 0.0});
  sim::Parameters parameters = some_parameters();
  const std::vector<float> sway = recorded(protocol, parameters, 0.0, 4);
  const Observation observation = density.observe(sway);
  Values x(static_cast<std::size_t>(density.size()) * lanes, 0.0);
  for (int chain = 0; chain < lanes; ++chain)
    density.set({.parameters = parameters, .sensor_noise_deg = 0.02}, x, chain);
  const Random normals(5, Stream::vestibular_noise, 4);
  const double radius = std::sqrt(parameters[sim::Nv] * parameters[sim::Nv] + 0.05 * 0.05);
  for (int i = 0; i < density.noise_size() / 2; ++i) {
    const int k = i + 2;
    if (k > period_s) continue;
    // The simulator's deviation is the density at k times 1 / period, the basis' the integral over its band.
    const double from = std::max(1.6, k - 0.5), to = std::min(period_s, k + 0.5);
    const double ratio = std::sqrt(1.0 / k / std::log(to / from)) * radius;
    const std::complex<double> turned = std::complex<double>(normals.normal(2 * static_cast<std::uint64_t>(k) + 1),
                                                             normals.normal(2 * static_cast<std::uint64_t>(k))) *
                                        std::polar(ratio, 2.0 * sim::pi * k * density.first_bin_s() / period_s);
    for (std::size_t l = 0; l < lanes; ++l) at(x, 2 * i, l) = turned.imag(), at(x, 2 * i + 1, l) = turned.real();
  }
  Density::Workspace work(density);
  const auto size = static_cast<std::size_t>(density.blocks()) * lanes;
  Values modelled(size), residual(size);
  density.model(observation, x, modelled, residual, work);
  double error = 0.0, power = 0.0;
  for (std::size_t m = 0; m < static_cast<std::size_t>(density.blocks()); ++m) {
    error += residual[m * lanes] * residual[m * lanes];
    power += observation.sway[m] * observation.sway[m];
    CHECK(modelled[m * lanes] == modelled[m * lanes + 5]);
  }
  const double rms_deg = std::sqrt(error / density.blocks()) / sim::rad_per_deg;
  CHECK(std::sqrt(power / density.blocks()) / sim::rad_per_deg > 0.1);
  CHECK(rms_deg < 1e-3);  // bins of 50 ms, 5 Hz; a sensor of 0.02 degrees leaves 6e-3 in a block of 100 ms
}

TEST_CASE("Density: what is perceived is the noise, and what of it and the platform passes the dead band") {
  const sim::Protocol protocol = sines_protocol();
  const Density density(protocol, {});
  const Values x = random_points(density, 5);
  const auto size = static_cast<std::size_t>(density.edges()) * lanes;
  CHECK(density.edges() == 401);
  CHECK(near(density.bin_s(), 0.05, 1e-15));
  CHECK(near(density.block_s(), 0.1, 1e-15));
  Values noise(size), tilt(size), none(size - 1);
  Density::Workspace work(density);
  density.perceive(x, noise, tilt, work);
  CHECK_THROWS_AS(density.perceive(x, noise, none, work), Error);
  CHECK_THROWS_AS(density.perceive(x, none, tilt, work), Error);
  CHECK_THROWS_AS(density.perceive(none, noise, tilt, work), Error);

  const NoiseBasis basis(protocol, 50, protocol.experiment.steps() / 50 + 8, 5.0);
  REQUIRE(basis.size() == density.noise_size());
  const sim::Stimulus stimulus = sim::make_stimulus(protocol.experiment);
  std::vector<double> column(static_cast<std::size_t>(basis.edges()));
  for (std::size_t l = 0; l < lanes; l += 5) {
    const sim::Parameters parameters = density.state(x, static_cast<int>(l)).parameters;
    const double nv = parameters[sim::Nv], theta = parameters[sim::Theta];
    std::vector<double> expected(column.size(), 0.0);
    for (int i = 0; i < basis.size(); ++i) {
      basis.column(i, column);
      const double factor = nv / std::sqrt(nv * nv + 0.05 * 0.05) * x[static_cast<std::size_t>(i) * lanes + l];
      for (std::size_t edge = 0; edge < column.size(); ++edge) expected[edge] += factor * column[edge];
    }
    // Half-way between edges the cubic through four of them, at the ends the line.
    const auto middle = [&](std::size_t edge) {
      const double near = expected[edge] + expected[edge + 1];
      return edge == 0 ? 0.5 * near : (9.0 * near - expected[edge - 1] - expected[edge + 2]) / 16.0;
    };
    // Step by step, as the simulator integrates; halves of bins take velocities for straight lines.
    double estimate = 0.0, largest = 0.0, worst = 0.0;
    for (std::size_t edge = 0; edge < static_cast<std::size_t>(density.edges()); ++edge) {
      CHECK(within(noise[edge * lanes + l], expected[edge], 1e-12));
      worst = std::max(worst, std::abs(tilt[edge * lanes + l] - estimate));
      largest = std::max(largest, std::abs(estimate));
      for (int j = 0; j < 50 && edge + 1 < static_cast<std::size_t>(density.edges()); ++j) {
        const double between = (j % 25 + 0.5) / 25.0;
        const double low = j < 25 ? expected[edge] : middle(edge), high = j < 25 ? middle(edge) : expected[edge + 1];
        const double velocity =
            stimulus.rate_at(static_cast<int>(edge) * 50 + j) + (1.0 - between) * low + between * high;
        estimate += sim::integration_step_s * (velocity - std::clamp(velocity, -theta, theta));
      }
    }
    CHECK(largest > 1e-3);
    CHECK(worst < 1e-3 * largest);
  }
}

TEST_CASE("Density: the information is that of the model's derivatives and of the prior") {
  const sim::Protocol protocol = sines_protocol();
  const Density density(protocol, {});
  const Observation observation = density.observe(recorded(protocol, some_parameters(), 0.02, 0));
  const Values x = random_points(density, 2);
  Density::Workspace work(density);
  const auto size = static_cast<std::size_t>(density.size()),
             length = static_cast<std::size_t>(density.blocks()) * lanes;
  std::vector<double> information(triangle(size) * lanes);
  density.information(observation, x, information, work);
  const int noises = density.noise_size();
  const std::vector<int> some{0,          1,          11,         noises - 1, noises,     noises + 1, noises + 2,
                              noises + 3, noises + 4, noises + 5, noises + 6, noises + 8, noises + 9};
  std::vector<Values> columns;
  const double step = 1e-5;
  for (const int i : some) {
    Values high = x, low = x, modelled(length), above(length), below(length);
    for (std::size_t l = 0; l < lanes; ++l) at(high, i, l) += step, at(low, i, l) -= step;
    density.model(observation, high, modelled, above, work);
    density.model(observation, low, modelled, below, work);
    for (std::size_t m = 0; m < length; ++m) above[m] = (above[m] - below[m]) / (2.0 * step);
    columns.push_back(above);
  }
  for (std::size_t a = 0; a < some.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      for (std::size_t l = 0; l < lanes; ++l) {
        const double noise = density.block_noise_rad(density.state(x, static_cast<int>(l)).sensor_noise_deg);
        double product = 0.0, of_a = 0.0, of_b = 0.0;
        for (std::size_t m = 0; m < static_cast<std::size_t>(density.blocks()); ++m) {
          product += columns[a][m * lanes + l] * columns[b][m * lanes + l];
          of_a += columns[a][m * lanes + l] * columns[a][m * lanes + l];
          of_b += columns[b][m * lanes + l] * columns[b][m * lanes + l];
        }
        const std::size_t entry = triangle(static_cast<std::size_t>(some[a])) + static_cast<std::size_t>(some[b]);
        const double scale = std::sqrt(of_a * of_b) / (noise * noise);
        CHECK(within(information[entry * lanes + l], product / (noise * noise), 4e-4 * scale));  // kinks within a step
      }
    }
  }
  std::vector<double> factor;
  for (std::size_t i = 0; i < triangle(size); ++i) factor.push_back(information[i * lanes + 1]);
  const std::vector<double> matrix = factor;
  CHECK(factorize(size, factor));

  // The same, and what follows from it, chain by chain in lanes.
  const Kernels& run = kernels(density.isa());
  AlignedVector<double> lane_factors(information.begin(), information.end());
  run.factorize(density.size(), lane_factors.data());
  double worst = 0.0;
  for (std::size_t i = 0; i < triangle(size); ++i)
    worst = std::max(worst, std::abs(lane_factors[i * lanes + 1] - factor[i]) / std::abs(factor[triangle(size) - 1]));
  CHECK(worst < 1e-8);
  Values ones(size * lanes, 1.0), solution(size * lanes, 1.0), product(size * lanes, 0.0);
  run.solve_transposed(density.size(), lane_factors.data(), solution.data());
  for (std::size_t column = 0; column < size; ++column) {
    double sum = 0.0;
    for (std::size_t row = column; row < size; ++row)
      sum += lane_factors[(triangle(row) + column) * lanes + 1] * at(solution, static_cast<int>(row), 1);
    REQUIRE(near(sum, 1.0, 1e-8));
  }
  run.symmetric_times(density.size(), information.data(), ones.data(), product.data());
  for (std::size_t row = 0; row < size; ++row) {
    double sum = 0.0, scale = 0.0;
    for (std::size_t column = 0; column < size; ++column) {
      const double value = matrix[triangle(std::max(row, column)) + std::min(row, column)];
      sum += value;
      scale += std::abs(value);
    }
    REQUIRE(within(at(product, static_cast<int>(row), 1), sum, 1e-12 * scale));
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

TEST_CASE("Density: states are set and read, those outside of the ranges at their edge") {
  const Density density(sines_protocol(), {});
  Values x(static_cast<std::size_t>(density.size()) * lanes, 0.0);
  State state{.parameters = some_parameters(), .sensor_noise_deg = 0.05, .start_s = 0.03, .gain = 0.95};
  density.set(state, x, 2);
  const State back = density.state(x, 2);
  for (std::size_t i = 0; i < state.parameters.size(); ++i) CHECK(near(back.parameters[i], state.parameters[i], 1e-12));
  CHECK(near(back.sensor_noise_deg, 0.05, 1e-12));
  CHECK(near(back.start_s, 0.03, 1e-12));
  CHECK(near(back.gain, 0.95, 1e-12));
  state.parameters[sim::Kp] = 1e9;
  density.set(state, x, 2);
  const sim::ParameterInfo& info = density.protocol().parameters()[sim::Kp];
  CHECK(near(density.state(x, 2).parameters[sim::Kp], info.low + 0.99 * info.range(), 1e-12));
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
  const auto size = static_cast<std::size_t>(density.blocks()) * lanes;
  Values modelled(size), residual(size);
  Density::Workspace work(density);
  density.model(observation, x, modelled, residual, work);
  double worst = 0.0, largest = 0.0;
  for (std::size_t m = 20; m + 2 < static_cast<std::size_t>(density.blocks()); ++m) {
    // Cubic interpolation of the blocks at 0.9 of one to the next.
    const auto y = [&](std::size_t k) { return modelled[k * lanes]; };
    const double t = 0.09 / block_s;
    const double between = -t * (t - 1) * (t - 2) / 6 * y(m - 1) + (t + 1) * (t - 1) * (t - 2) / 2 * y(m) -
                           (t + 1) * t * (t - 2) / 2 * y(m + 1) + (t + 1) * t * (t - 1) / 6 * y(m + 2);
    worst = std::max(worst, std::abs(modelled[m * lanes + 1] - between));
    largest = std::max(largest, std::abs(y(m)));
    CHECK(near(modelled[m * lanes + 2], 0.93 * y(m), 1e-12));
  }
  CHECK(worst < 1e-3 * largest);
}

TEST_CASE("Density: errors") {
  sim::Protocol protocol = sines_protocol();
  const Density density(protocol, {});
  check_error([&] { density.observe(std::vector<float>(1999)); }, {"recording", "1999 samples", "2000"});
  protocol.experiment.stimulus =
      sim::Sines{.components = {{.frequency_hz = 0.6, .amplitude_deg = 0.7}}, .cycle_s = 1.9};
  protocol.noise.vestibular.low_hz = 0.5;
  check_error([&] { Density short_one(protocol, {}); }, {"lasts 1.9 s", "2 s at least"});
  protocol = sines_protocol();
  protocol.noise.vestibular.low_hz = protocol.noise.vestibular.high_hz = 0.1;
  check_error([&] { Density one_line(protocol, {}); }, {"vestibular_noise", "single frequency"});
  for (const Priors& wrong :
       {Priors{.sensor_noise_deg = 0.0}, Priors{.sensor_noise_factor = 1.0}, Priors{.start_s = -0.1},
        Priors{.start_s = 1.1}, Priors{.gain = 1.0}, Priors{.gain = std::nan("")}, Priors{.drift_hz = -1.0},
        Priors{.sensor_noise_deg = HUGE_VAL}, Priors{.sensor_noise_factor = HUGE_VAL}, Priors{.drift_hz = HUGE_VAL}})
    check_error([&] { Density(sines_protocol(), wrong); }, {"priors, ", "give"});

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
