// Many trials at once: each has the bits of its trial alone, for every instruction set; errors from inside.

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <vector>

#include "base/error.hpp"
#include "base/isa.hpp"
#include "sim/simulate.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"
#include "tests/sim/run.hpp"

using namespace decid::sim;
using decid::Random;
using decid::Stream;
using namespace decid::test;

TEST_CASE("Simulator::run_all: each trial as if alone, whatever falls, with every instruction set" *
          doctest::test_suite("slow")) {
  // The plain kernel takes one lane at a time.
  const Simulator plain(Protocol{}, decid::Isa::reference);
  const auto make_trial = [](int index) {
    const Random random(3, streams::base_parameters, static_cast<std::uint64_t>(index));
    Parameters parameters(single_pendulum().parameters.size());
    for (std::size_t i = 0; i < single_pendulum().parameters.size(); ++i) {
      parameters[i] = random.uniform(i, single_pendulum().parameters[i].low, single_pendulum().parameters[i].high);
    }
    if (index % 5 == 0) parameters[Nv] = 0.0;
    if (index % 7 == 0) parameters[Delay] = 0.001 * (index % 3);
    return TrialInput{parameters, Random(3, streams::vestibular_noise, static_cast<std::uint64_t>(index))};
  };
  constexpr int count = 45;
  std::vector<Run> alone;
  int fallen = 0;
  for (int index = 0; index < count; ++index) {
    const TrialInput trial = make_trial(index);
    alone.push_back(simulate(plain, trial.parameters, trial.noise));
    fallen += alone.back().outcome.valid ? 0 : 1;
  }
  CHECK(fallen > 0);
  CHECK(fallen < count);
  for (const decid::Isa isa : decid::available_isas()) {
    CAPTURE(name(isa));
    std::vector<int> visits(count);
    Simulator(Protocol{}, isa).run_all(count, make_trial, [&](int i, const Outcome& outcome, std::span<double> sway) {
      const auto index = static_cast<std::size_t>(i);
      ++visits[index];
      const Run& expected = alone[index];
      // Called from many threads: doctest's assertions are made for that.
      CHECK(outcome.valid == expected.outcome.valid);
      CHECK(outcome.max_sway_rad == expected.outcome.max_sway_rad);
      CHECK(outcome.end_s == expected.outcome.end_s);
      const auto samples = static_cast<std::ptrdiff_t>(outcome.end_s * 100.0 + 0.5);
      CHECK(std::equal(sway.begin(), sway.begin() + samples, expected.sway.begin()));
    });
    CHECK(std::all_of(visits.begin(), visits.end(), [](int n) { return n == 1; }));
  }
}

TEST_CASE("Simulator::run_all: each trial of every controller as if alone, with every instruction set") {
  for (const BodyModel* model : {&dec2015(), &independent_channels()}) {
    CAPTURE(model->name);
    Protocol protocol = short_protocol();
    protocol.experiment.body_model = model;
    const auto make_trial = [&](int index) {
      const auto number = static_cast<std::uint64_t>(index);
      const Random random(3, streams::base_parameters, number);
      Parameters parameters = model->parameters.middle();
      for (std::size_t i = 0; i < parameters.size(); ++i)
        parameters[i] += 0.1 * (random.uniform(i) - 0.5) * model->parameters[i].range();
      return TrialInput{parameters, Random(3, streams::vestibular_noise, number)};
    };
    const Simulator plain(protocol, decid::Isa::reference);
    for (const decid::Isa isa : decid::available_isas()) {
      CAPTURE(name(isa));
      Simulator(protocol, isa).run_all(17, make_trial, [&](int i, const Outcome& outcome, std::span<double> sway) {
        const TrialInput trial = make_trial(i);
        const Run expected = simulate(plain, trial.parameters, trial.noise);
        CHECK(outcome.valid);
        CHECK(outcome.max_sway_rad == expected.outcome.max_sway_rad);
        CHECK(std::equal(sway.begin(), sway.end(), expected.sway.begin()));
      });
    }
  }
}

TEST_CASE("Simulator::run_all: other sample rates and grids, the commands' memory wraps around") {
  Protocol protocol = short_protocol();
  protocol.sequence().offset_s = 0.001;  // a grid of 1 ms
  for (const double rate_hz : {20.0, 1000.0}) {
    protocol.experiment.sample_rate_hz = rate_hz;
    const auto make_trial = [](int index) {
      Parameters parameters = single_pendulum().parameters.middle();
      parameters[Delay] = index == 0 ? longest_delay_s : 0.02 * index;
      return TrialInput{parameters, Random(8, streams::vestibular_noise, static_cast<std::uint64_t>(index))};
    };
    const Simulator simulator(protocol), plain(protocol, decid::Isa::reference);
    simulator.run_all(9, make_trial, [&](int index, const Outcome& outcome, std::span<double> sway) {
      const TrialInput trial = make_trial(index);
      const Run expected = simulate(plain, trial.parameters, trial.noise);
      CHECK(outcome.end_s == expected.outcome.end_s);
      const auto samples = static_cast<std::ptrdiff_t>(outcome.end_s * rate_hz + 0.5);
      CHECK(std::equal(sway.begin(), sway.begin() + samples, expected.sway.begin()));
    });
  }
}

TEST_CASE("Simulator::run_all: each trial with its own body") {
  const auto make_trial = [](int index) {
    TrialInput trial{single_pendulum().parameters.middle(),
                     Random(8, streams::vestibular_noise, static_cast<std::uint64_t>(index))};
    if (index % 3 > 0) trial.height = 0.8 + 0.01 * index;
    return trial;
  };
  const Simulator simulator(short_protocol());
  simulator.run_all(40, make_trial, [&](int index, const Outcome& outcome, std::span<double> sway) {
    const TrialInput trial = make_trial(index);
    Protocol own = short_protocol();
    own.experiment.body = Body{}.of_height(trial.height);
    const Run expected = simulate(Simulator(own), trial.parameters, trial.noise);
    CHECK(outcome.max_sway_rad == expected.outcome.max_sway_rad);
    CHECK(std::equal(sway.begin(), sway.end(), expected.sway.begin()));
  });
  CHECK(near(Body{}.of_height(0.9).mgh(), Body{}.mgh(), 1e-15));
  CHECK(near(Body{}.of_height(0.9).height_over(Body{}), 0.9, 1e-15));
  for (const double height : {0.0, 10.1, std::numeric_limits<double>::quiet_NaN()}) {
    const auto giant = [&](int index) {
      TrialInput trial = make_trial(index);
      trial.height = height;
      return trial;
    };
    decid::test::check_error([&] { simulator.run_all(1, giant, [](int, const Outcome&, std::span<double>) {}); },
                             decid::Code::setting_out_of_range, "0.1 to");
  }
}

TEST_CASE("Simulator::run_all: nothing to do, and errors from inside") {
  const Simulator simulator(short_protocol());
  const auto middle = [](int) { return TrialInput{single_pendulum().parameters.middle(), some_noise}; };
  int finished = 0;
  simulator.run_all(0, middle, [&](int, const Outcome&, std::span<double>) { ++finished; });
  CHECK(finished == 0);
  const auto wrong = [&](int index) {
    TrialInput trial = middle(index);
    if (index == 17) trial.parameters[Kd] = -1.0;
    return trial;
  };
  CHECK_THROWS_AS(simulator.run_all(20, wrong, [](int, const Outcome&, std::span<double>) {}), decid::Error);
  const auto fail = [](int, const Outcome&, std::span<double>) { throw std::runtime_error("disk full"); };
  CHECK_THROWS_WITH_AS(simulator.run_all(20, middle, fail), "disk full", std::runtime_error);
}
