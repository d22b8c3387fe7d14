// Tests of sim/simulate.hpp: unstable trials, standing, errors, and the bits of one trial. family.cpp has linear
// theory, and a second implementation written straight from the equations.
#include "sim/simulate.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "base/error.hpp"
#include "base/files/sha256.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"
#include "tests/sim/run.hpp"
#include "tests/sim/straightforward.hpp"

using namespace decid::sim;
using decid::Random;
using namespace decid::test;

TEST_CASE("Outcome: as many samples as end before it, without rounding one away") {
  for (int k = 0; k <= 20'000; ++k)
    REQUIRE(Outcome{.valid = false, .max_sway_rad = 0.1, .end_s = k / 100.0}.samples(100.0) ==
            static_cast<std::size_t>(k));
}

TEST_CASE("closed_loop: its formula") {
  const Parameters parameters{900.0, 250.0, 200.0, 120.0, 0.0, 0.0, 0.137};
  const Body body;
  for (const double f : {0.0, 0.01, 0.3, 1.0, 7.3, 20.0}) {
    const std::complex<double> s(0.0, 2.0 * pi * f);
    const auto passive = 200.0 + 120.0 * s;
    const auto exact =
        passive / (body.inertia_kgm2 * s * s - body.mgh() + 2.0 * (900.0 + 250.0 * s) * std::exp(-s * 0.137) + passive);
    CHECK(std::abs(closed_loop(Experiment{}, parameters, f) - exact) < 1e-13 * std::abs(exact));
  }
}

TEST_CASE("Simulator: a fall is reported when it happens") {
  const Protocol protocol;
  const Simulator simulator(protocol);
  Parameters parameters = single_pendulum().parameters.middle();
  parameters[Kp] = parameters[Kd] = 0.0;  // passive stiffness alone does not hold the body
  const Run trial = simulate(simulator, parameters);
  const std::vector<double> sway = straightforward(protocol, parameters, some_noise);
  CHECK_FALSE(trial.outcome.valid);
  // To the end of the sample period in which it happens.
  CHECK(trial.outcome.end_s == std::ceil(static_cast<double>(sway.size() - 1) / 10.0) / 100.0);
  CHECK(trial.outcome.end_s > 1.0);
  CHECK(trial.outcome.end_s < 20.0);
  CHECK(trial.outcome.max_sway_rad > sway_limit_rad);
  CHECK(trial.outcome.max_sway_rad < 1.01 * sway_limit_rad);
  // Samples up to the fall are written, later ones are not.
  const auto last = static_cast<std::size_t>((sway.size() - 2) / 10);
  CHECK(trial.sway[last] != 0.0);
  CHECK(trial.sway[last + 1] == 0.0);

  // Gains beyond all reason overflow at once: invalid, and no NaN.
  std::ranges::fill(parameters, std::numeric_limits<double>::max());
  parameters[Nv] = parameters[Theta] = parameters[Delay] = 0.0;
  const Outcome overflow = simulate(simulator, parameters).outcome;
  CHECK_FALSE(overflow.valid);
  CHECK(overflow.end_s < 0.5);
  CHECK(overflow.max_sway_rad > sway_limit_rad);
}

namespace {

constexpr double standing_s = 10.0;

/// The trial and the standing before it as one.
Protocol with_lead_in(Protocol protocol) {
  protocol.noise.vestibular.period_s = protocol.noise_period_s();
  protocol.sequence().lead_in_s += standing_s;
  return protocol;
}

Protocol standing_before(Protocol protocol) {
  protocol.standing_s = standing_s;
  return protocol;
}

}  // namespace

TEST_CASE("Simulator: a body that has stood has the bits of a trial whose first seconds are cut") {
  for (const double rate_hz : {20.0, 100.0}) {
    for (Protocol protocol : {default_protocol(), short_protocol()}) {
      protocol.experiment.sample_rate_hz = rate_hz;
      const Simulator simulator(standing_before(protocol)), whole(with_lead_in(protocol)), from_rest(protocol);
      CHECK(simulator.samples() == protocol.samples());
      CHECK(simulator.protocol().standing_s == standing_s);
      CHECK(simulator.stimulus().tilt_rad == from_rest.stimulus().tilt_rad);
      CHECK(simulator.stimulus().rate_rad_s == from_rest.stimulus().rate_rad_s);
      const Parameters parameters = single_pendulum().parameters.middle();
      const Run trial = simulate(simulator, parameters), longer = simulate(whole, parameters);
      REQUIRE(longer.outcome.valid);
      CHECK(trial.outcome.valid);
      CHECK(trial.outcome.end_s == protocol.duration_s());
      CHECK(trial.outcome.max_sway_rad == longer.outcome.max_sway_rad);
      CHECK(std::ranges::equal(trial.sway, std::span(longer.sway).last(trial.sway.size())));
      CHECK(trial.sway.front() != 0.0);
      // Together with others, too.
      simulator.run_all(
          20,
          [&](int i) {
            return TrialInput{parameters,
                              i == 7 ? some_noise : Random(4, streams::child_noise, static_cast<std::uint64_t>(i))};
          },
          [&](int i, const Outcome&, std::span<double> sway) {
            CHECK(sway.size() == trial.sway.size());
            if (i == 7) CHECK(std::ranges::equal(sway, trial.sway));
          });
      // Without noise it has stood at rest.
      Parameters silent = parameters;
      silent[Nv] = 0.0;
      CHECK(simulate(simulator, silent).sway == simulate(from_rest, silent).sway);
    }
  }
}

TEST_CASE("Simulator: a platform that moved before gives the bits of a longer trial whose first cycle is cut") {
  for (const double seconds : {0.0, standing_s}) {
    Protocol protocol;
    Protocol longer = protocol;
    protocol.moved_before = true;
    protocol.standing_s = seconds;
    longer.noise.vestibular.period_s = protocol.noise_period_s();
    longer.sequence().lead_in_s = seconds;
    longer.sequence().cycles = 3;
    const Simulator simulator(protocol), whole(longer), rested(Protocol{});
    CHECK(simulator.samples() == 12'100);
    CHECK(simulator.stimulus().tilt_rad == rested.stimulus().tilt_rad);
    Parameters parameters = single_pendulum().parameters.middle();
    const Run trial = simulate(simulator, parameters), all = simulate(whole, parameters);
    CHECK(std::ranges::equal(trial.sway, std::span(all.sway).last(12'100)));
    // The body begins with the sway of the cycle's end.
    parameters[Nv] = 0.0;
    const std::vector<double> sway = simulate(simulator, parameters).sway;
    CHECK(sway.front() != 0.0);
    CHECK(within(sway.front(), sway[6050], 1e-6));
  }
}

TEST_CASE("Simulator: who falls while standing falls at 0, and nothing is written") {
  const Protocol protocol;
  const Simulator simulator(standing_before(protocol)), whole(with_lead_in(protocol));
  Parameters parameters = single_pendulum().parameters.middle();
  int standing = 0, later = 0;
  for (const double kp : {0.0, 100.0, 150.0, 200.0, 250.0, 280.0, 900.0}) {
    parameters[Kp] = kp;
    const Outcome longer = simulate(whole, parameters).outcome;
    std::vector<double> sway(12'100, 7.0);
    const Outcome outcome = simulator.run(parameters, some_noise, sway);
    CHECK(outcome.valid == longer.valid);
    CHECK(outcome.max_sway_rad == longer.max_sway_rad);
    CHECK(near(outcome.end_s, std::max(0.0, longer.end_s - standing_s), 1e-9));
    const auto written = std::ranges::count_if(sway, [](double value) { return value != 7.0; });
    CHECK(written == std::lround(100.0 * outcome.end_s));
    (longer.end_s <= standing_s ? standing : later) += longer.valid ? 0 : 1;
  }
  CHECK(standing > 0);
  CHECK(later > 0);
}

TEST_CASE("Simulator: errors") {
  const Simulator simulator{Protocol{}};
  const ParameterTable& table = single_pendulum().parameters;
  std::vector<double> sway(12'100);
  const auto running = [&](std::size_t index, double value) {
    Parameters parameters = table.middle();
    parameters[index] = value;
    return [&, parameters] { simulator.run(parameters, some_noise, sway); };
  };
  const auto refused = [](const auto& run, const std::string& name) {
    check_error(run, decid::Code::setting_out_of_range, "parameter " + name);
  };
  for (std::size_t i = 0; i < table.size(); ++i) {
    for (const double wrong :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -1e-9})
      refused(running(i, wrong), table[i].name);
    CHECK_NOTHROW(running(i, 0.0)());
  }
  CHECK_NOTHROW(running(Delay, 1.0)());
  refused(running(Delay, 1.0001), "delay");
  sway.pop_back();
  check_error(running(Kp, 900.0), decid::Code::size_mismatch, "12099");
  Protocol broken;
  broken.sequence().cycles = 0;
  CHECK_THROWS_AS(Simulator{broken}, decid::Error);
}

TEST_CASE("Simulator: the bits of a noisy trial") {
  const Simulator simulator{Protocol{}};
  const auto digest = [](const std::vector<double>& values) {
    return decid::sha256({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double)});
  };
  const Run trial = simulate(simulator, single_pendulum().parameters.middle());
  REQUIRE(trial.outcome.valid);
  CHECK(digest(trial.sway) == digest(simulate(simulator, single_pendulum().parameters.middle()).sway));
  // Promised for every compiler and instruction set: a change here changes every data set.
  CHECK(digest(simulator.stimulus().tilt_rad) == "4f29123331b36035fe695bc95d05562a400d56f766979b3e9a1ef6f904d189b3");
  CHECK(digest(trial.sway) == "26f2853dc7866c1547505407ca7045e56e06268f62fad3de14b5dc03b2ab9753");
}
