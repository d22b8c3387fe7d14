// Tests of the trials of sim/double_pendulum.hpp: against linear theory and the equations written straight down;
// falls, errors. Its mechanics: double_body.cpp.
#include "sim/double_pendulum.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <string>

#include "base/error.hpp"
#include "base/files/sha256.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"
#include "tests/sim/double_constants.hpp"

using namespace decid::sim;
using decid::Random;
using namespace decid::test;

namespace {

const Random some_noise(1, streams::vestibular_noise, 0);

struct Run {
  Outcome outcome;
  std::vector<double> com, leg, trunk;
};

Run simulate(const DoubleSimulator& simulator, const DoubleParameters& parameters, const Random& noise = some_noise) {
  const std::vector<double> room(static_cast<std::size_t>(simulator.samples()));
  Run trial{{}, room, room, room};
  trial.outcome = simulator.run(parameters, noise, {trial.com, trial.leg, trial.trunk});
  return trial;
}

DoubleParameters defaults() {
  return default_double_parameters(make_segments(make_participant(Body{})));
}

DoubleParameters quiet() {
  DoubleParameters parameters = defaults();
  parameters.ankle[Nv] = parameters.ankle[Theta] = parameters.hip[Theta] = 0.0;
  return parameters;
}

// The trial, equation by equation, every signal kept whole on the 1 ms grid: leg and trunk of every step.
std::array<std::vector<double>, 2> straightforward(const DoubleSimulator& simulator, const DoubleParameters& parameters,
                                                   const Random& noise) {
  const Protocol& protocol = simulator.protocol();
  const Constants c(simulator.segments());
  const auto per_sample = static_cast<std::size_t>(protocol.experiment.steps_per_sample());
  std::vector<double> nu(static_cast<std::size_t>(protocol.samples()) + 1);
  VestibularNoiseMaker(protocol).velocity(1.0, noise, nu);
  const double dt = 0.001;
  std::vector<double> p1{0.0}, p2{0.0}, v1{0.0}, v2{0.0}, u[2];
  double estimate[2] = {0.0, 0.0};
  const Parameters* const module[2] = {&parameters.ankle, &parameters.hip};
  for (std::size_t k = 0; k < static_cast<std::size_t>(protocol.experiment.steps()); ++k) {
    const double f = simulator.stimulus().tilt_at(static_cast<int>(k));
    const double f_rate = simulator.stimulus().rate_at(static_cast<int>(k));
    const double part = static_cast<double>(k % per_sample) / static_cast<double>(per_sample);
    const double nu_rate = (1.0 - part) * nu[k / per_sample] + part * nu[k / per_sample + 1];
    const double body[2] = {c.w1 * p1[k] + c.w2 * p2[k], p2[k]}, body_rate[2] = {c.w1 * v1[k] + c.w2 * v2[k], v2[k]};
    const double support[2] = {f, p1[k]}, support_rate[2] = {f_rate, v1[k]};
    const double joint[2] = {p1[k] - f, p2[k] - p1[k]}, joint_rate[2] = {v1[k] - f_rate, v2[k] - v1[k]};
    double torque[2];
    for (const std::size_t j : {0u, 1u}) {
      const Parameters& p = *module[j];
      const double x = support_rate[j] + p[Nv] * nu_rate;
      const double e_rate = x > p[Theta] ? x - p[Theta] : x < -p[Theta] ? x + p[Theta] : 0.0;
      u[j].push_back(p[Kp] * (body[j] + (estimate[j] + body[j] - support[j])) +
                     p[Kd] * (body_rate[j] + (e_rate + body_rate[j] - support_rate[j])));
      estimate[j] += dt * e_rate;
      const double position = static_cast<double>(k) - std::round(p[Delay] * 1e6) / 1e3;
      double active = 0.0;
      if (position >= 0.0) {
        const auto before = static_cast<std::size_t>(position);
        const double fraction = position - static_cast<double>(before);
        active = fraction == 0.0 ? u[j][before] : (1.0 - fraction) * u[j][before] + fraction * u[j][before + 1];
      }
      torque[j] = -active - p[Kp_pass] * joint[j] - p[Kd_pass] * joint_rate[j];
    }
    const double b = c.b * std::cos(p1[k] - p2[k]), s = c.b * std::sin(p1[k] - p2[k]);
    const double r1 = torque[0] - torque[1] - s * v2[k] * v2[k] + c.g1 * std::sin(p1[k]);
    const double r2 = torque[1] + s * v1[k] * v1[k] + c.g2 * std::sin(p2[k]);
    // Gauss: the trunk's acceleration from the second equation into the first.
    const double acceleration1 = (r1 - b / c.a2 * r2) / (c.a1 - b * b / c.a2);
    const double acceleration2 = (r2 - b * acceleration1) / c.a2;
    v1.push_back(v1[k] + dt * acceleration1);
    v2.push_back(v2[k] + dt * acceleration2);
    p1.push_back(p1[k] + dt * v1[k + 1]);
    p2.push_back(p2[k] + dt * v2[k + 1]);
  }
  return {p1, p2};
}

}  // namespace

TEST_CASE("DoubleSimulator: equals the equations written straight down") {
  Protocol protocol;
  const auto check = [&](const DoubleParameters& parameters, const Random& noise) {
    const DoubleSimulator simulator(protocol);
    const Run trial = simulate(simulator, parameters, noise);
    const auto [leg, trunk] = straightforward(simulator, parameters, noise);
    const Constants c(simulator.segments());
    REQUIRE(trial.outcome.valid);
    double difference = 0.0, largest = 0.0, sway = 0.0;
    for (std::size_t k = 0; k < leg.size(); ++k) {
      largest = std::max({largest, std::abs(leg[k]), std::abs(trunk[k])});
      sway = std::max(sway, std::abs(c.w1 * leg[k] + c.w2 * trunk[k]));
    }
    const auto per_sample = static_cast<std::size_t>(protocol.experiment.steps_per_sample());
    for (std::size_t k = 0; k < trial.com.size(); ++k) {
      const double p1 = leg[k * per_sample], p2 = trunk[k * per_sample];
      difference = std::max({difference, std::abs(trial.leg[k] - p1), std::abs(trial.trunk[k] - p2),
                             std::abs(trial.com[k] - (c.w1 * p1 + c.w2 * p2))});
    }
    // As the single pendulum's: roundings that a stable loop forgets within seconds; some thousand eps, and ten times
    // that for the slower decay of two joints.
    CHECK(difference < 1e-11 * largest);
    CHECK(near(trial.outcome.max_sway_rad, sway, 1e-11));
    CHECK(trial.outcome.end_s == protocol.duration_s());
  };
  check(defaults(), some_noise);
  DoubleParameters parameters = defaults();
  parameters.hip[Nv] = 0.3;
  parameters.ankle[Delay] = 0.1207;
  parameters.hip[Delay] = 0.0305;
  check(parameters, Random(2, streams::child_noise, 3));
  parameters.ankle[Nv] = 0.0;
  parameters.ankle[Theta] = 0.0;
  check(parameters, some_noise);
  protocol = short_protocol();
  protocol.experiment.body = make_body(make_segments({.mass_kg = 60.0, .height_m = 1.6}));
  protocol.experiment.sample_rate_hz = 50.0;
  protocol.sequence().lead_in_s = 2.0;
  protocol.sequence().lead_out_s = 0.0;
  check(default_double_parameters(make_segments({.mass_kg = 60.0, .height_m = 1.6})), some_noise);
  // Delays of whole steps, of parts of them, and the longest, for which passive springs hold the body.
  protocol = short_protocol();
  const double delays[][2] = {{0.0, 0.0004}, {0.001, 0.0}, {0.07, 0.0025}, {0.1 + 0.02, 0.03}, {1.0, 1.0}};
  for (const auto& delay : delays) {
    parameters = defaults();
    parameters.ankle[Delay] = delay[0];
    parameters.hip[Delay] = delay[1];
    if (delay[0] == 1.0) {
      for (Parameters* joint : {&parameters.ankle, &parameters.hip}) (*joint)[Kp] *= 0.05, (*joint)[Kd] *= 0.05;
      parameters.ankle[Kp_pass] += 1500.0;
      parameters.ankle[Kd_pass] += 300.0;
      parameters.hip[Kp_pass] += 600.0;
      parameters.hip[Kd_pass] += 60.0;
    }
    check(parameters, some_noise);
  }
}

TEST_CASE("DoubleSimulator: small sway follows the transfer matrix") {
  Protocol protocol;
  protocol.sequence().amplitude_deg = 0.01;  // angles below 1e-3 rad: linear to 1e-7
  protocol.experiment.sample_rate_hz = 1000.0;
  const DoubleSimulator simulator(protocol);
  const Constants c(simulator.segments());
  constexpr std::size_t cycle = 60'500;
  const RealFft fft(static_cast<int>(cycle));
  std::vector<Complex> tilt(static_cast<std::size_t>(fft.bins())), leg(tilt), trunk(tilt), com(tilt);
  std::vector<Complex> work(static_cast<std::size_t>(fft.work_length()));
  std::vector<double> tilt_rad;
  for (int k = 0; k < static_cast<int>(cycle); ++k) tilt_rad.push_back(simulator.stimulus().tilt_at(k));
  fft.forward(tilt_rad, tilt, work);

  // Leg and trunk for a tilt of 1. D, E: the velocities of body and platform per angle; S: acceleration per angle;
  // e: the leg as the hip estimates it; a, h: the delays.
  struct Operators {
    Complex D, E, S, e, a, h;
  };
  const auto response = [&](const DoubleParameters& p, const Operators& o) {
    const Complex ankle = 2.0 * (p.ankle[Kp] + p.ankle[Kd] * o.D) * o.a,
                  hip = 2.0 * (p.hip[Kp] + p.hip[Kd] * o.D) * o.h;
    const Complex estimate = p.hip[Kp] * (o.e - 1.0) * o.h;
    const Complex ankle_passive = p.ankle[Kp_pass] + p.ankle[Kd_pass] * o.D;
    const Complex hip_passive = p.hip[Kp_pass] + p.hip[Kd_pass] * o.D;
    // t_ankle = -(ankle w1 + ankle_passive) P1 - ankle w2 P2 + drive, t_hip = hip_1 P1 + hip_2 P2
    const Complex hip_1 = hip_passive - estimate, hip_2 = -hip - hip_passive;
    const Complex drive = p.ankle[Kp_pass] + p.ankle[Kd_pass] * o.E;
    const Complex m11 = c.a1 * o.S - c.g1 + ankle * c.w1 + ankle_passive + hip_1,
                  m12 = c.b * o.S + ankle * c.w2 + hip_2;
    const Complex m21 = c.b * o.S - hip_1, m22 = c.a2 * o.S - c.g2 - hip_2;
    const Complex determinant = m11 * m22 - m12 * m21;
    return std::array<Complex, 2>{drive * m22 / determinant, -drive * m21 / determinant};
  };

  DoubleParameters stiff = quiet();
  stiff.ankle[Delay] = 0.1004;
  stiff.hip[Delay] = 0.0;
  stiff.hip[Kp_pass] *= 2.0;
  for (const DoubleParameters& parameters : {quiet(), stiff}) {
    const Run trial = simulate(simulator, parameters);
    REQUIRE(trial.outcome.valid);
    fft.forward(std::span(trial.leg).subspan(cycle), leg, work);
    fft.forward(std::span(trial.trunk).subspan(cycle), trunk, work);
    fft.forward(std::span(trial.com).subspan(cycle), com, work);
    double exact_error = 0.0, continuous_error = 0.0;
    for (std::size_t k = 1; k < 73; k += 2) {
      const double omega = 2.0 * pi * static_cast<double>(k) / 60.5, dt = 0.001;
      const Complex s(0.0, omega), z = std::exp(s * dt);
      const auto delay = [&](double delay_s) {
        const double steps = delay_s / dt, whole = std::floor(steps + 1e-6), part = std::max(0.0, steps - whole);
        return std::pow(z, -whole) * (1.0 - part + part / z);
      };
      // Semi-implicit Euler: v_k = (p_k - p_k-1) / dt, and the hip's estimate is the leg one step earlier.
      const Operators discrete{(1.0 - 1.0 / z) / dt,
                               (z - 1.0) / dt,
                               (z - 2.0 + 1.0 / z) / (dt * dt),
                               1.0 / z,
                               delay(parameters.ankle[Delay]),
                               delay(parameters.hip[Delay])};
      const Operators continuous{
          s, s, s * s, 1.0, std::exp(-s * parameters.ankle[Delay]), std::exp(-s * parameters.hip[Delay])};
      const auto exact = response(parameters, discrete), ideal = response(parameters, continuous);
      const Complex found[2] = {leg[k] / tilt[k], trunk[k] / tilt[k]};
      for (const std::size_t j : {0u, 1u}) {
        exact_error = std::max(exact_error, std::abs(found[j] - exact[j]) / std::abs(exact[j]));
        continuous_error = std::max(continuous_error, std::abs(found[j] - ideal[j]) / std::abs(ideal[j]));
      }
      CHECK(std::abs(com[k] - (c.w1 * leg[k] + c.w2 * trunk[k])) < 1e-12 * std::abs(leg[k]));
    }
    // The remaining error is sin(x) - x.
    CHECK(exact_error < 1e-6);
    // Half a step's lag, 0.4% at 1.2 Hz, as of the single pendulum; at most doubled by the second joint.
    CHECK(continuous_error < 0.02);
  }
}

TEST_CASE("DoubleSimulator: falls") {
  const DoubleSimulator simulator{Protocol{}};
  DoubleParameters parameters = defaults();
  parameters.ankle[Kp] = parameters.ankle[Kd] = 0.0;
  const Run trial = simulate(simulator, parameters);
  CHECK_FALSE(trial.outcome.valid);
  CHECK(trial.outcome.end_s > 1.0);
  CHECK(trial.outcome.end_s < 20.0);
  CHECK(trial.outcome.max_sway_rad > sway_limit_rad);
  CHECK(trial.outcome.max_sway_rad < 1.01 * sway_limit_rad);
  // Samples up to the fall are written, later ones are not.
  const auto last = static_cast<std::size_t>(std::ceil(trial.outcome.end_s * 100.0)) - 1;
  CHECK(trial.com[last] != 0.0);
  CHECK(trial.leg[last] != 0.0);
  CHECK(trial.trunk[last] != 0.0);
  CHECK(trial.com[last + 1] == 0.0);
  CHECK(trial.leg[last + 1] == 0.0);
  CHECK(trial.trunk[last + 1] == 0.0);

  // The trunk swings against the leg with growing amplitude, the centre of mass between them.
  parameters = defaults();
  parameters.hip[Kp] *= 4.0;
  parameters.hip[Delay] = 0.2;
  const Outcome swinging = simulate(simulator, parameters).outcome;
  CHECK_FALSE(swinging.valid);
  CHECK(swinging.max_sway_rad < sway_limit_rad);

  std::ranges::fill(parameters.ankle, std::numeric_limits<double>::max());
  parameters.ankle[Nv] = parameters.ankle[Theta] = parameters.ankle[Delay] = 0.0;
  const Outcome overflow = simulate(simulator, parameters).outcome;
  CHECK_FALSE(overflow.valid);
  CHECK(overflow.end_s < 0.5);
  CHECK(overflow.max_sway_rad > sway_limit_rad);
}

TEST_CASE("DoubleSimulator: a body that has stood has the bits of a trial whose first seconds are cut") {
  Protocol protocol = short_protocol(), longer = protocol;
  protocol.standing_s = 10.0;
  longer.noise.vestibular.period_s = protocol.noise_period_s();
  longer.sequence().lead_in_s += 10.0;
  const DoubleSimulator simulator(protocol), whole(longer);
  const Run trial = simulate(simulator, defaults()), all = simulate(whole, defaults());
  CHECK(trial.outcome.valid);
  CHECK(trial.outcome.end_s == 63.7);
  CHECK(std::ranges::equal(trial.com, std::span(all.com).last(trial.com.size())));
  CHECK(std::ranges::equal(trial.leg, std::span(all.leg).last(trial.leg.size())));
  CHECK(std::ranges::equal(trial.trunk, std::span(all.trunk).last(trial.trunk.size())));
  CHECK(trial.com.front() != 0.0);

  DoubleParameters falling = defaults();
  falling.ankle[Kp] *= 0.2;  // enough for the noise to move the body, too little to hold it
  const Run fallen = simulate(simulator, falling);
  CHECK(simulate(whole, falling).outcome.end_s < 10.0);
  CHECK_FALSE(fallen.outcome.valid);
  CHECK(fallen.outcome.end_s == 0.0);
  CHECK(std::ranges::all_of(fallen.com, [](double value) { return value == 0.0; }));
}

TEST_CASE("DoubleSimulator: errors") {
  const DoubleSimulator simulator{Protocol{}};
  const std::vector<double> room(12'100);
  Run trial{{}, room, room, room};
  const auto running = [&](const DoubleParameters& parameters) {
    return [&, parameters] { simulator.run(parameters, some_noise, {trial.com, trial.leg, trial.trunk}); };
  };
  const auto refused = [](const auto& run, const char* parameter) {
    check_error(run, decid::Code::setting_out_of_range, parameter);
  };
  // tests/sim/simulate.cpp has every parameter.
  DoubleParameters wrong = defaults(), late = defaults();
  wrong.ankle[Kd] = std::numeric_limits<double>::quiet_NaN();
  refused(running(wrong), "ankle parameter Kd");
  late.hip[Delay] = 1.0001;
  refused(running(late), "hip parameter delay");
  CHECK_NOTHROW(running(defaults())());
  for (std::vector<double>* out : {&trial.com, &trial.leg, &trial.trunk}) {
    out->pop_back();
    check_error(running(defaults()), decid::Code::size_mismatch);
    out->push_back(0.0);
  }
  Protocol broken;
  broken.sequence().cycles = 0;
  CHECK_THROWS_AS(DoubleSimulator{broken}, decid::Error);
  Protocol odd;
  odd.experiment.body.inertia_kgm2 = 80.0;
  check_error([&] { DoubleSimulator{odd}; }, decid::Code::setting_conflict);
}

TEST_CASE("DoubleSimulator: the bits of a noisy trial") {
  const Run trial = simulate(DoubleSimulator{Protocol{}}, defaults());
  REQUIRE(trial.outcome.valid);
  const auto digest = [](const std::vector<double>& values) {
    return decid::sha256({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double)});
  };
  // Promised for every compiler and instruction set.
  CHECK(digest(trial.leg) == "37af67ce4362fe4a673e78a780ba925e26a520c344b4179c58caf9c552c144db");
  CHECK(digest(trial.trunk) == "6a03937501f79fb9b24b08899225b0b6bf25a80e75500ea17e6d30a28b8b39f5");
}
