// A cycle that was copied, such as the mean of cycles: found, and not in trials of bodies without any noise.
#include "recording/quality/detail/repeated_cycle.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/math/random.hpp"
#include "recording/resample.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"
#include "tests/recording/default_protocol.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

/// Returns trial i of the prior in rad, without measurement noise; without vestibular noise if `is_noise_free`.
std::vector<double> trial(std::uint64_t i, bool is_noise_free) {
  return trial_of_prior(12, i, [&](sim::Parameters& parameters) {
    if (is_noise_free) parameters[sim::Nv] = 0.0;
  });
}

/// Returns the warnings of a sway in rad of the protocol of `of`, recorded at its rate.
Warnings found(const std::vector<double>& sway_rad, const ProtocolPlan& of = plan()) {
  return look_for_repeated_cycle(sway_rad, of, of.protocol().experiment.sample_rate_hz);
}

/// Returns the sway in steps of a power of ten of degrees, as a file with so few decimals has it.
std::vector<double> with_decimals(std::vector<double> sway_rad, int decimals) {
  const double step_rad = std::pow(10.0, -decimals) * sim::rad_per_deg;
  for (double& value : sway_rad) value = std::round(value / step_rad) * step_rad;
  return sway_rad;
}

/// Returns the mean of both cycles of a trial, written twice.
std::vector<double> mean_of_cycles(std::vector<double> sway_rad) {
  const std::size_t half = sway_rad.size() / 2;
  for (std::size_t k = 0; k < half; ++k) sway_rad[k] = sway_rad[half + k] = 0.5 * (sway_rad[k] + sway_rad[half + k]);
  return sway_rad;
}

/// Returns a sway of the default controller without noise: at full precision, in steps of 0.001 and of 0.01 degrees.
std::vector<std::vector<double>> noise_free(const sim::Simulator& of, sim::Parameters parameters) {
  parameters[sim::Nv] = 0.0;
  std::vector<double> sway(static_cast<std::size_t>(of.samples()));
  REQUIRE(of.run(parameters, Random(12, sim::streams::vestibular_noise, 0), sway).valid);
  return {sway, with_decimals(sway, 3), with_decimals(sway, 2)};
}

}  // namespace

TEST_CASE("a mean of cycles that is written twice gets a caution: with few digits, another end, at any rate") {
  for (std::uint64_t i = 0; i < 10; ++i) {
    std::vector<double> mean = mean_of_cycles(trial(i, false));
    const Warnings warnings = found(mean);
    REQUIRE(warnings.size() == 1);
    CHECK(warnings[0].code == "repeated_cycle");
    CHECK(warnings[0].severity == Severity::caution);
    CHECK(found(with_decimals(mean, 3)).size() == 1);
    CHECK(found(with_decimals(mean, 2)).size() == 1);
    const std::size_t half = mean.size() / 2;
    for (std::size_t k = half - 100; k < half; ++k) mean[k] += 1e-3;
    CHECK(found(mean).size() == 1);
  }
  for (const double rate_hz : {50.0, 100.0, 128.0, 1000.0}) {
    std::vector<double> sway = resample(trial(3, false), 100.0, rate_hz);
    REQUIRE(sway.size() % 2 == 0);
    Recording recording = make_recording(mean_of_cycles(std::move(sway)), rate_hz);
    bring_to_protocol(recording, plan());
    CHECK(std::ranges::count(recording.warnings, "repeated_cycle", &Warning::code) == 1);
  }
}

TEST_CASE("trials repeat no cycle, also without any noise and with few digits") {
  for (std::uint64_t i = 0; i < 40; ++i) {
    const std::vector<double> sway = trial(i, i % 2 == 0);
    for (const int decimals : {2, 3, 9}) CHECK(found(with_decimals(sway, decimals)).empty());
  }
  for (const auto& sway : noise_free(simulator(), simulator().protocol().parameters().middle()))
    CHECK(found(sway).empty());
}

TEST_CASE("a stiff body without noise, which settles within 1.2 s, repeats no cycle") {
  sim::Parameters stiff = simulator().protocol().parameters().middle();
  stiff[sim::Theta] = 0.0;
  stiff[sim::Kp] = 2500.0;
  stiff[sim::Kd] = 500.0;
  stiff[sim::Delay] = 0.01;
  for (const auto& sway : noise_free(simulator(), stiff)) {
    CHECK(found(sway).empty());
    Recording recording = make_recording(resample(sway, 100.0, 200.0), 200.0);
    bring_to_protocol(recording, plan());
    CHECK(std::ranges::count(recording.warnings, "repeated_cycle", &Warning::code) == 0);
  }
}

TEST_CASE("a body without noise repeats no cycle of 240 to 800 s, unless 0.01 degrees hide its start") {
  for (const double cycle_s : {240.0, 400.0, 800.0}) {
    for (const double frequency_hz : {1.0 / cycle_s, 0.1}) {
      sim::Protocol slow = sim::default_protocol();
      slow.experiment.stimulus = sim::Sines{.components = {{frequency_hz, 0.5, 0.0}}, .cycle_s = cycle_s, .cycles = 2};
      const sim::Simulator of(slow);
      const ProtocolPlan slow_plan(slow);
      const auto sways = noise_free(of, slow.parameters().middle());
      CHECK(found(sways[0], slow_plan).empty());
      CHECK(found(sways[1], slow_plan).empty());
      if (frequency_hz > 0.002) CHECK(found(sways[2], slow_plan).empty());
    }
  }
}

TEST_CASE("a still sway, one with a spike per cycle, the tilt itself and a protocol of one cycle repeat no cycle") {
  std::vector<double> still(12100, 0.3 * sim::rad_per_deg);
  CHECK(found(still).empty());
  still[700] = still[6750] = 0.1;
  CHECK(found(still).empty());
  std::vector<double> tilt = plan().tilt_rad();
  CHECK(found(tilt).empty());
  for (double& value : tilt) value *= -1.0;
  CHECK(found(tilt).empty());
  sim::Protocol one_cycle = sim::default_protocol();
  one_cycle.sequence().cycles = 1;
  const std::vector<double> repeated = mean_of_cycles(trial(0, false));
  REQUIRE(found(repeated).size() == 1);
  CHECK(found(repeated, ProtocolPlan(one_cycle)).empty());
}
