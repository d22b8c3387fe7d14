// The frequency response of simulated trials is the closed loop's, its circles hold the truth as often as they say, and
// noise has no coherence.
#include "sim/frf.hpp"

#include <doctest/doctest.h>

#include <cmath>

#include "base/error.hpp"
#include "sim/simulate.hpp"
#include "sim/streams.hpp"
#include "tests/near.hpp"

using namespace decid;
using namespace decid::sim;
using namespace decid::test;

namespace {

std::vector<float> tilt_for(const Protocol& protocol) {
  const Stimulus stimulus = make_stimulus(protocol.experiment);
  std::vector<float> tilt;
  for (int k = 0; k < protocol.samples(); ++k) {
    tilt.push_back(static_cast<float>(stimulus.tilt_at(k * protocol.experiment.steps_per_sample())));
  }
  return tilt;
}

std::vector<float> sway_of(const Protocol& protocol, const Parameters& parameters, std::uint64_t realisation) {
  const Simulator simulator(protocol);
  std::vector<double> sway(static_cast<std::size_t>(protocol.samples()));
  REQUIRE(simulator.run(parameters, Random(5, sim::streams::vestibular_noise, realisation), sway).valid);
  return {sway.begin(), sway.end()};
}

//                        Kp     Kd     Kp_pass Kd_pass Nv   theta delay
const Parameters linear_body{900.0, 250.0, 200.0, 120.0, 0.0, 0.0, 0.1};

}  // namespace

TEST_CASE("FrequencyResponse: without noise it is the closed loop's") {
  // The first cycle is left out: its transient has died out in the second. The remaining error is the integration's
  // step of 1 ms: torques from the state at its start and velocity before position lag by half a step each, so one step
  // in the loop's delay and one at the output bound it. Rounding to float adds 1e-4 where the response is smallest.
  for (Protocol protocol : {default_protocol(), short_protocol()}) {
    CAPTURE(protocol.name);
    protocol.sequence().amplitude_deg = 0.01;  // sin(a) = a to 1e-8
    const FrequencyResponse analysis(protocol.experiment, 1);
    const std::vector<FrfPoint> points = analysis.measure(sway_of(protocol, linear_body, 0), tilt_for(protocol));
    const std::vector<Complex> expected = analysis.linear(protocol.experiment, linear_body);
    Parameters later = linear_body;
    later[Delay] += 0.001;
    const std::vector<Complex> lagging = analysis.linear(protocol.experiment, later);
    REQUIRE(points.size() == expected.size());
    REQUIRE(points.size() >= 12);
    double last = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      CAPTURE(points[i].frequency_hz);
      CHECK(points[i].frequency_hz > last);
      last = points[i].frequency_hz;
      const double bound =
          std::abs(lagging[i] - expected[i]) + (2.0 * pi * last / 1000.0 + 1e-4) * std::abs(expected[i]);
      CHECK(std::abs(points[i].response - expected[i]) < bound);
      CHECK(points[i].coherence > 0.999);
    }
    CHECK(near(points.front().frequency_hz, 1.0 / protocol.experiment.cycle_s(), 1e-15));
    CHECK(last > 2.0);
    CHECK(last < 4.0);
  }
}

TEST_CASE("FrequencyResponse: bands are the closed loop's own at one harmonic each") {
  const FrequencyResponse fine(default_protocol().experiment, 0, 1e6), coarse(default_protocol().experiment, 0, 10.0);
  CHECK(fine.bands() > 60);  // odd harmonics up to about 2.5 Hz
  CHECK(coarse.bands() < 20);
  const std::vector<Complex> each = fine.linear(Experiment{}, linear_body);
  for (const std::size_t i : {std::size_t{0}, std::size_t{1}, std::size_t{30}}) {
    const double frequency = (2.0 * static_cast<double>(i) + 1.0) / 60.5;  // the odd ones
    const Complex exact = closed_loop(Experiment{}, linear_body, frequency);
    CHECK(std::abs(each[i] - exact) < 1e-12 * std::abs(exact));
  }
}

TEST_CASE("FrequencyResponse: 95% of the circles hold the true response") {
  // White noise on a known gain: the assumptions hold exactly, except that neighbouring bands share noise lines. Among
  // n independent circles 0.95 n +- 4 sqrt(0.95 0.05 n) hold the gain. Trials are independent; within one, count every
  // third band, which share none.
  for (Protocol protocol : {default_protocol(), short_protocol()}) {
    for (const int skipped : {0, protocol.experiment.cycles() - 1}) {
      CAPTURE(protocol.name);
      CAPTURE(skipped);
      const std::vector<float> tilt = tilt_for(protocol);
      const FrequencyResponse analysis(protocol.experiment, skipped);
      int held = 0, all = 0;
      for (std::uint64_t trial = 0; trial < 150; ++trial) {
        const Random random(11, sim::streams::sensor_noise, trial);
        std::vector<float> sway(tilt.size());
        for (std::size_t k = 0; k < sway.size(); ++k) {
          sway[k] = static_cast<float>(0.7 * static_cast<double>(tilt[k]) + 0.01 * random.normal(k));
        }
        const std::vector<FrfPoint> points = analysis.measure(sway, tilt);
        for (std::size_t i = 0; i < points.size(); i += 3, ++all) {
          if (std::abs(points[i].response - 0.7) <= points[i].radius) ++held;
        }
      }
      const double expected = 0.95 * all, stddev = std::sqrt(0.05 * expected);
      CAPTURE(all);
      CHECK(std::abs(held - expected) < 4.0 * stddev);
    }
  }
}

TEST_CASE("FrequencyResponse: circles of noisy simulated trials hold the closed loop") {
  // Vestibular noise is not white and the trial starts from rest, so that only about 95% hold it: 90% to 99%, as the
  // standard error of more than 400 circles is 1.1% at most.
  Parameters parameters = linear_body;
  parameters[Nv] = 0.5;
  const Protocol protocol;
  const std::vector<float> tilt = tilt_for(protocol);
  const FrequencyResponse analysis(protocol.experiment);
  const std::vector<Complex> expected = analysis.linear(protocol.experiment, parameters);
  int held = 0, all = 0;
  for (std::uint64_t trial = 0; trial < 40; ++trial) {
    const std::vector<FrfPoint> points = analysis.measure(sway_of(protocol, parameters, trial), tilt);
    for (std::size_t i = 0; i < points.size() && points[i].frequency_hz < 1.0; ++i, ++all) {
      if (std::abs(points[i].response - expected[i]) <= points[i].radius) ++held;
    }
  }
  CAPTURE(held);
  CAPTURE(all);
  REQUIRE(all > 400);
  CHECK(held > 0.90 * all);
  CHECK(held < 0.99 * all);
}

TEST_CASE("FrequencyResponse: noise alone is not coherent") {
  const Protocol protocol;
  const std::vector<float> tilt = tilt_for(protocol);
  const FrequencyResponse analysis(protocol.experiment);
  double sum = 0.0;
  int count = 0;
  for (std::uint64_t trial = 0; trial < 100; ++trial) {
    const Random random(12, sim::streams::sensor_noise, trial);
    std::vector<float> sway(tilt.size());
    for (std::size_t k = 0; k < sway.size(); ++k) sway[k] = static_cast<float>(0.01 * random.normal(k));
    for (const FrfPoint& point : analysis.measure(sway, tilt)) {
      sum += point.coherence;
      ++count;
    }
  }
  // With a known s2 and one harmonic, u = |Y|^2 / s2 is exponential and the mean of max(0, u - 1) / (u - 1 + 2) is the
  // integral of exp(-1 - v) v / (v + 2), 0.102; s2 from 12 degrees of freedom and bands move it by a little.
  CHECK(sum / count < 0.15);
  CHECK(sum / count > 0.05);
}

TEST_CASE("FrequencyResponse: the coherence is that of a single cycle") {
  // For a known gain in white noise: |0.7 X|^2 over the sum of |0.7 X|^2 and N sigma^2, for the N samples of a cycle.
  const Protocol protocol;
  const std::vector<float> tilt = tilt_for(protocol);
  const FrequencyResponse analysis(protocol.experiment);
  constexpr int cycle = 6'050, trials = 100;
  const RealFft fft(cycle);
  std::vector<Complex> x(static_cast<std::size_t>(fft.bins())), work(static_cast<std::size_t>(fft.work_length()));
  fft.forward(std::vector<double>(tilt.begin(), tilt.begin() + cycle), x, work);
  int compared = 0;
  for (const double stddev : {0.005, 0.01, 0.02, 0.05}) {
    std::vector<double> mean(static_cast<std::size_t>(analysis.bands()));
    std::vector<FrfPoint> points;
    for (std::uint64_t trial = 0; trial < trials; ++trial) {
      const Random random(13, sim::streams::sensor_noise, trial);
      std::vector<float> sway(tilt.size());
      for (std::size_t k = 0; k < sway.size(); ++k) {
        sway[k] = static_cast<float>(0.7 * static_cast<double>(tilt[k]) + stddev * random.normal(k));
      }
      points = analysis.measure(sway, tilt);
      for (std::size_t i = 0; i < points.size(); ++i) mean[i] += points[i].coherence / trials;
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (points[i].harmonics != 1) continue;
      const auto harmonic =
          static_cast<std::size_t>(std::lround(points[i].frequency_hz * protocol.experiment.cycle_s()));
      const double signal = 0.49 * std::norm(x[harmonic]);
      const double expected = signal / (signal + cycle * stddev * stddev);
      if (expected < 0.75 || expected > 0.95) continue;
      CAPTURE(expected);
      // One trial's is u / (u + 2), u the signal's power over the noise's. u scatters by its root times 2, and the
      // noise, of six lines, by 1 / sqrt(6): to the second order they move the mean by `bias`. With the power of one
      // cycle's noise for that of two it would be 0.04 to 0.1 higher.
      const double c = expected, u = 2 * c / (1 - c);
      const double bias = c * (1 - c) * (1 - c) / 6 - 2 * (2 * u + 1) / std::pow(u + 2, 3);
      const double scatter = 2 / ((u + 2) * (u + 2)) * std::sqrt(2 * u + 1) + c * (1 - c) / std::sqrt(6);
      CHECK(within(mean[i], c + bias, 4 * scatter / std::sqrt(trials) + 0.5 * std::abs(bias)));
      ++compared;
    }
  }
  CHECK(compared >= 3);
}

TEST_CASE("FrequencyResponse: no response is an error, no noise lines a flag") {
  Protocol step;
  step.experiment.stimulus = RaisedCosines{{{Move::Shape::step, 1.0, 2.0, 1.0}}, 20.0, 1, 0.0, 0.0};
  CHECK_THROWS_AS(FrequencyResponse{step.experiment}, Error);
  CHECK_THROWS_AS(FrequencyResponse(default_protocol().experiment, 2), Error);
  Protocol uneven;
  uneven.experiment.sample_rate_hz = 1.0;
  uneven.sequence().cycles = 1;
  CHECK_THROWS_AS(FrequencyResponse{uneven.experiment}, Error);  // 60.5 samples
  CHECK_THROWS_AS(
      FrequencyResponse(default_protocol().experiment).measure(std::vector<float>(12099), tilt_for(Protocol{})), Error);

  Protocol from_peak;  // a cycle may start and end anywhere, if at the same tilt
  from_peak.experiment.stimulus = Sines{{{0.25, 0.5, 90.0}}, 20.0, 2, 0.0, 0.0};
  CHECK(FrequencyResponse{from_peak.experiment}.bands() > 0);

  Protocol pulse;  // one cycle, all harmonics excited
  pulse.experiment.stimulus = RaisedCosines{{{Move::Shape::pulse, 1.0, 4.0, 1.0}}, 20.0, 1, 0.0, 0.0};
  const FrequencyResponse analysis(pulse.experiment);
  const std::vector<float> tilt = tilt_for(pulse);
  const std::vector<FrfPoint> points = analysis.measure(tilt, tilt);
  REQUIRE_FALSE(points.empty());
  CHECK(std::abs(points[0].response - 1.0) < 1e-12);
  CHECK(std::isnan(points[0].radius));
  CHECK(std::isnan(points[0].coherence));
}
