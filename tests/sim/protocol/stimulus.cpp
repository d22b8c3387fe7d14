// Tests of sim/protocol/stimulus.hpp: measured tilts, sines and raised cosines against their formulas, and every bound.
// Ternary sequences: tests/sim/protocol/protocol.cpp.
#include "sim/protocol/stimulus.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "base/error.hpp"
#include "base/files/sha256.hpp"
#include "sim/protocol/protocol.hpp"
#include "sim/simulate.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"

using namespace decid::sim;
using namespace decid::test;

namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();
const auto not_a_number = std::numeric_limits<double>::quiet_NaN();

Protocol playing(StimulusKind kind, double sample_rate_hz = 100.0) {
  Protocol protocol;
  protocol.name = "mine";
  protocol.experiment.stimulus = std::move(kind);
  protocol.experiment.sample_rate_hz = sample_rate_hz;
  // So short a trial has no harmonic in the noise's band.
  if (protocol.duration_s() < 1.0) protocol.noise.vestibular.scale_deg = 0.0;
  protocol.validate();
  return protocol;
}

MeasuredTilt measured() {
  return {.tilt_deg = {1.5, 1.75, 1.25, 1.0, 1.5, 2.0}};
}

Sines sines() {
  return {.components = {{.frequency_hz = 0.1, .amplitude_deg = 0.5},
                         {.frequency_hz = 0.7, .amplitude_deg = 0.25, .phase_deg = 90.0}},
          .cycle_s = 10.0};
}

RaisedCosines cosines() {
  return {.moves = {{.shape = Move::Shape::pulse, .start_s = 1.0, .duration_s = 2.0, .amplitude_deg = 1.0},
                    {.shape = Move::Shape::step, .start_s = 3.0, .duration_s = 0.5, .amplitude_deg = -2.0},
                    {.shape = Move::Shape::pulse, .start_s = 4.005, .duration_s = 0.99, .amplitude_deg = 0.5},
                    {.shape = Move::Shape::step, .start_s = 6.0, .duration_s = 1.0, .amplitude_deg = 2.0}},
          .cycle_s = 8.0};
}

// The velocity is that of the straight line between the points.
void check_lines(const Stimulus& stimulus, const Protocol& protocol) {
  REQUIRE(stimulus.interval_steps == protocol.experiment.steps_per_sample());
  REQUIRE(stimulus.tilt_rad.size() == static_cast<std::size_t>(protocol.samples()) + 1);
  REQUIRE(stimulus.rate_rad_s.size() == static_cast<std::size_t>(protocol.samples()));
  CHECK(stimulus.tilt_rad[0] == 0.0);
  const int per_sample = protocol.experiment.steps_per_sample();
  double error = 0.0;
  for (int k = 0; k < protocol.samples(); ++k) {
    const double next = stimulus.tilt_rad[static_cast<std::size_t>(k)] +
                        stimulus.rate_at(k * per_sample) / protocol.experiment.sample_rate_hz;
    error = std::max(error, std::abs(next - stimulus.tilt_rad[static_cast<std::size_t>(k) + 1]));
  }
  CHECK(error < 4.0 * eps * stimulus.peak_to_peak_rad());
}

}  // namespace

TEST_CASE("measured tilt: the samples, their first called 0, at the sample rate") {
  const Protocol protocol = playing(measured());
  CHECK(protocol.samples() == 6);
  CHECK(protocol.experiment.cycle_s() == 0.06);
  CHECK(protocol.duration_s() == 0.06);
  CHECK(protocol.experiment.cycles() == 1);
  const Stimulus stimulus = make_stimulus(protocol.experiment);
  check_lines(stimulus, protocol);
  // After its last sample the platform stays.
  const std::vector<double> expected_deg{0.0, 0.25, -0.25, -0.5, 0.0, 0.5, 0.5};
  for (std::size_t k = 0; k < expected_deg.size(); ++k) CHECK(stimulus.tilt_rad[k] == expected_deg[k] * rad_per_deg);
  CHECK(stimulus.rate_rad_s[5] == 0.0);
  // Half of 0.25 to -0.25 degrees: roundings of what is below half a degree.
  CHECK(within(stimulus.tilt_at(15), 0.0, eps * rad_per_deg));
  CHECK(stimulus.peak_to_peak_rad() == rad_per_deg);
}

TEST_CASE("every kind: lead-in, cycles and lead-out") {
  const auto check = [](auto kind, double rate_hz) {
    const Protocol alone = playing(kind, rate_hz);
    kind.cycles = 3;
    kind.lead_in_s = 0.2;
    kind.lead_out_s = 0.5;
    const Protocol protocol = playing(kind, rate_hz);
    const auto n = static_cast<std::size_t>(alone.samples()), in = static_cast<std::size_t>(0.2 * rate_hz);
    CHECK(protocol.experiment.cycles() == 3);
    CHECK(protocol.experiment.lead_in_s() == 0.2);
    CHECK(protocol.experiment.cycle_s() == alone.duration_s());
    CHECK(protocol.samples() == static_cast<int>(3 * n + in + static_cast<std::size_t>(0.5 * rate_hz)));
    const Stimulus one = make_stimulus(alone.experiment), three = make_stimulus(protocol.experiment);
    check_lines(three, protocol);
    for (std::size_t k = 0; k < three.tilt_rad.size(); ++k) {
      const double expected = k < in ? 0.0 : k < in + 3 * n ? one.tilt_rad[(k - in) % n] : one.tilt_rad.back();
      REQUIRE(three.tilt_rad[k] == expected);
    }
  };
  check(measured(), 100.0);
  check(sines(), 100.0);
  check(sines(), 20.0);
  check(cosines(), 200.0);
}

TEST_CASE("sines: their formula") {
  const Protocol protocol = playing(sines());
  const Stimulus stimulus = make_stimulus(protocol.experiment);
  check_lines(stimulus, protocol);
  double error = 0.0;
  for (int k = 0; k <= 1000; ++k) {
    const long double turn = 2.0L * 3.14159265358979323846264338327950288L, t = k / 100.0L;
    const long double exact = 0.5L * std::sin(turn * 0.1L * t) + 0.25L * (std::cos(turn * 0.7L * t) - 1.0L);
    error = std::max(error, static_cast<double>(std::abs(stimulus.tilt_rad[static_cast<std::size_t>(k)] / rad_per_deg -
                                                         static_cast<double>(exact))));
  }
  // 7 periods: the product f t is rounded to 7 eps/2 of a turn, 2 pi of which are radians; the phase to half an eps.
  CHECK(error < 0.75 * 2.0 * pi * 8.0 * eps);
  CHECK(stimulus.peak_to_peak_rad() > 1.0 * rad_per_deg);
}

TEST_CASE("raised cosines: there and back, to stay, and rest between") {
  const Protocol protocol = playing(cosines());
  const Stimulus stimulus = make_stimulus(protocol.experiment);
  check_lines(stimulus, protocol);
  const auto deg = [&](double t) { return stimulus.tilt_at(static_cast<int>(std::lround(1000.0 * t))) / rad_per_deg; };
  for (const double t : {0.0, 0.5, 1.0, 3.0, 7.0, 7.99, 8.0}) CHECK(std::abs(deg(t)) <= eps);
  // The cosine is right to 3/4 of eps, and what takes it to degrees rounds five times; where both subtract, of 2
  // degrees.
  CHECK(near(deg(2.0), 1.0, 4.0 * eps));
  CHECK(near(deg(1.5), 0.5, 4.0 * eps));
  CHECK(within(deg(1.2), 0.5 * (1.0 - std::cos(2.0 * pi * 0.1)), 4.0 * eps));
  CHECK(near(deg(3.25), -1.0, 4.0 * eps));
  CHECK(within(deg(3.1), -1.0 + std::cos(pi * 0.2), 8.0 * eps));
  for (const double t : {3.5, 3.9, 4.0, 5.0, 6.0}) CHECK(near(deg(t), -2.0, 4.0 * eps));
  // The move starts 5 ms after a sample.
  CHECK(near(deg(4.5), -2.0 + 0.25 * (1.0 - std::cos(2.0 * pi * 0.495 / 0.99)), 4.0 * eps));
  CHECK(near(deg(6.5), -1.0, 4.0 * eps));
}

TEST_CASE("a measured tilt that is a sequence's gives its trial") {
  // At 100 Hz the default sequence is linear between samples, so only the roundings of degrees differ.
  const Protocol sequence;
  const Simulator simulator(sequence);
  MeasuredTilt tilt;
  for (int k = 0; k < sequence.samples(); ++k)
    tilt.tilt_deg.push_back(simulator.stimulus().tilt_at(10 * k) / rad_per_deg);
  const Simulator other(playing(tilt));
  std::vector<double> a(static_cast<std::size_t>(simulator.samples())), b(a.size());
  const decid::Random noise(1, decid::sim::streams::vestibular_noise, 0);
  REQUIRE(simulator.run(single_pendulum().parameters.middle(), noise, a).valid);
  REQUIRE(other.run(single_pendulum().parameters.middle(), noise, b).valid);
  double difference = 0.0, largest = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    difference = std::max(difference, std::abs(a[k] - b[k]));
    largest = std::max(largest, std::abs(a[k]));
  }
  // Tilts differ by eps, velocities by 100 eps / s; the stable loop adds up some seconds of them.
  CHECK(difference < 1e-12 * largest);
}

TEST_CASE("stimuli: the bits") {
  // Promised for every compiler and instruction set.
  const auto digest = [](const StimulusKind& kind) {
    const Stimulus stimulus = make_stimulus(playing(kind).experiment);
    return decid::sha256(
        {reinterpret_cast<const char*>(stimulus.tilt_rad.data()), stimulus.tilt_rad.size() * sizeof(double)});
  };
  CHECK(digest(sines()) == "0351381baf8a30aa9583295b0185c1843dc67d87f71e5b3683d87c8ff99557f2");
  CHECK(digest(cosines()) == "35e4c4460cbfb33f66402ba325358369cbe31840def48ebf40c731c1fb953df7");
}

TEST_CASE("stimuli: every bound") {
  struct Case {
    std::string says;
    std::function<void(Protocol&)> spoil;
  };
  const auto with = [](auto kind, auto change) {
    return [=](Protocol& p) {
      auto spoilt = kind;
      change(spoilt);
      p.experiment.stimulus = spoilt;
    };
  };
  const std::vector<Case> cases{
      {"measured tilt_deg: has 1 entries", with(measured(), [](auto& m) { m.tilt_deg = {1.0}; })},
      {"measured tilt_deg: has 1000001 entries", with(measured(), [](auto& m) { m.tilt_deg.assign(1'000'001, 0.0); })},
      {"measured tilt_deg: sample 2", with(measured(), [](auto& m) { m.tilt_deg[2] = not_a_number; })},
      {"measured tilt_deg: sample 1", with(measured(), [](auto& m) { m.tilt_deg[0] = 47.0; })},
      {"measured tilt_deg: sample 0", with(measured(), [](auto& m) { m.tilt_deg[0] = not_a_number; })},
      {"measured cycles", with(measured(), [](auto& m) { m.cycles = 0; })},
      {"measured lead_in_s", with(measured(), [](auto& m) { m.lead_in_s = -1.0; })},
      {"measured lead_in_s: is 0.005 s, not a whole number of samples",
       with(measured(), [](auto& m) { m.lead_in_s = 0.005; })},
      {"measured lead_out_s", with(measured(), [](auto& m) { m.lead_out_s = not_a_number; })},
      {"measured lead_out_s: is 0.005 s", with(measured(), [](auto& m) { m.lead_out_s = 0.005; })},
      {"at most 3600 s", with(measured(), [](auto& m) { m.cycles = 100'000; })},
      {"sines components: has 0 entries", with(sines(), [](auto& s) { s.components.clear(); })},
      {"sines components: has 101 entries", with(sines(), [](auto& s) { s.components.resize(101); })},
      {"sines components[1] frequency_hz", with(sines(), [](auto& s) { s.components[1].frequency_hz = 0.0; })},
      {"sines components[1] frequency_hz", with(sines(), [](auto& s) { s.components[1].frequency_hz = 10.01; })},
      {"sines components[0] frequency_hz", with(sines(), [](auto& s) { s.components[0].frequency_hz = not_a_number; })},
      {"sines components[0] frequency_hz: makes 1.05 periods",
       with(sines(), [](auto& s) { s.components[0].frequency_hz = 0.105, s.cycles = 2; })},
      {"sines components[0] amplitude_deg", with(sines(), [](auto& s) { s.components[0].amplitude_deg = -1.0; })},
      {"sines components[0] amplitude_deg", with(sines(), [](auto& s) { s.components[0].amplitude_deg = 45.1; })},
      {"sines components: have amplitudes", with(sines(), [](auto& s) { s.components[0].amplitude_deg = 44.9; })},
      {"sines components[1] phase_deg", with(sines(), [](auto& s) { s.components[1].phase_deg = 361.0; })},
      {"sines components[1] phase_deg", with(sines(), [](auto& s) { s.components[1].phase_deg = not_a_number; })},
      {"sines cycle_s", with(sines(), [](auto& s) { s.cycle_s = 0.0; })},
      {"sines cycle_s", with(sines(), [](auto& s) { s.cycle_s = 3601.0; })},
      {"sines cycle_s: is 10.005 s, not a whole number of samples", with(sines(), [](auto& s) { s.cycle_s = 10.005; })},
      {"sines cycle_s", with(sines(), [](auto& s) { s.cycle_s = 10.0005; })},
      {"sines cycles", with(sines(), [](auto& s) { s.cycles = -1; })},
      {"sines lead_in_s", with(sines(), [](auto& s) { s.lead_in_s = 4000.0; })},
      {"at most 3600 s", with(sines(), [](auto& s) { s.cycles = 361; })},
      {"raised_cosines moves: has 0 entries", with(cosines(), [](auto& c) { c.moves.clear(); })},
      {"raised_cosines moves: has 10001 entries", with(cosines(), [](auto& c) { c.moves.resize(10'001); })},
      {"raised_cosines moves[0] start_s", with(cosines(), [](auto& c) { c.moves[0].start_s = -0.1; })},
      {"raised_cosines moves[0] start_s", with(cosines(), [](auto& c) { c.moves[0].start_s = 0.0005; })},
      {"raised_cosines moves[1] start_s: is 2.99, before the previous move ends",
       with(cosines(), [](auto& c) { c.moves[1].start_s = 2.99; })},
      {"raised_cosines moves[1] duration_s", with(cosines(), [](auto& c) { c.moves[1].duration_s = 0.099; })},
      {"raised_cosines moves[1] duration_s", with(cosines(), [](auto& c) { c.moves[1].duration_s = 0.5005; })},
      {"raised_cosines moves[1] duration_s", with(cosines(), [](auto& c) { c.moves[1].duration_s = not_a_number; })},
      {"raised_cosines moves[3] duration_s: ends the move after",
       with(cosines(), [](auto& c) { c.moves[3].duration_s = 2.001; })},
      {"raised_cosines moves[0] amplitude_deg: is 0", with(cosines(), [](auto& c) { c.moves[0].amplitude_deg = 0.0; })},
      {"raised_cosines moves[0] amplitude_deg", with(cosines(), [](auto& c) { c.moves[0].amplitude_deg = -45.5; })},
      {"raised_cosines moves[2] amplitude_deg: takes the platform to -46",
       with(cosines(), [](auto& c) { c.moves[2].amplitude_deg = -44.0; })},
      {"raised_cosines moves: end a cycle at", with(cosines(), [](auto& c) { c.moves.pop_back(), c.cycles = 2; })},
      {"raised_cosines cycle_s", with(cosines(), [](auto& c) { c.cycle_s = not_a_number; })},
      {"raised_cosines cycles", with(cosines(), [](auto& c) { c.cycles = 100'001; })},
      {"raised_cosines lead_out_s: is 0.001 s", with(cosines(), [](auto& c) { c.lead_out_s = 0.001; })},
      {"at most 3600 s", with(cosines(), [](auto& c) { c.lead_out_s = 3599.0; })},
  };
  for (std::size_t i = 0; i < cases.size(); ++i) {
    Protocol protocol;
    cases[i].spoil(protocol);
    CAPTURE(i);
    check_error([&] { protocol.validate(); }, decid::Code::setting_out_of_range, cases[i].says);
  }
}

TEST_CASE("stimuli: a trial of fewer than four samples is refused") {
  for (const auto& tilt_deg : {std::vector{0.0, 1.0}, std::vector{0.0, 1.0, 0.0}})
    check_error([&] { playing(MeasuredTilt{.tilt_deg = tilt_deg}); }, decid::Code::setting_out_of_range, "samples");
}

TEST_CASE("stimuli: the ends of the bounds are inside") {
  Sines wave{.components = {{.frequency_hz = 10.0, .amplitude_deg = 45.0, .phase_deg = -360.0}}, .cycle_s = 3600.0};
  CHECK_NOTHROW(playing(wave));
  RaisedCosines move{
      .moves = {{.start_s = 0.0, .duration_s = 0.1, .amplitude_deg = -45.0}}, .cycle_s = 0.1, .cycles = 36'000};
  CHECK_NOTHROW(playing(move));
  CHECK_NOTHROW(playing(MeasuredTilt{.tilt_deg = {0.0, 45.0, 0.0, 45.0}}));
}

TEST_CASE("Protocol::sequence: only of a sequence") {
  Protocol protocol = playing(sines());
  check_error([&] { protocol.sequence(); }, decid::Code::setting_conflict);
  const Protocol& constant = protocol;
  CHECK_THROWS_AS(constant.sequence(), decid::Error);
}
