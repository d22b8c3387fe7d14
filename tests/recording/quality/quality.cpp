// Faults in the samples of sway: each is found where it is, and nowhere else.
#include "recording/quality/detail/quality.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/math/random.hpp"
#include "base/setting.hpp"
#include "sim/protocol/protocol.hpp"
#include "sim/simulate.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

constexpr double rate_hz = 100.0;

/// Slow sway of a degree, with white noise of this many degrees; in degrees.
std::vector<double> sway(double noise_deg, int samples = 4000) {
  const Random random(7, sim::streams::sensor_noise, 0);
  std::vector<double> values(static_cast<std::size_t>(samples));
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double t = static_cast<double>(k) / rate_hz;
    values[k] = std::sin(1.3 * t) + 0.3 * std::sin(4.1 * t) + noise_deg * random.normal(k);
  }
  return values;
}

Warnings found(std::vector<double> degrees, double at_hz = rate_hz) {
  for (double& value : degrees) value *= sim::rad_per_deg;
  return look_for_faults(degrees, at_hz).warnings;
}

/// The only warning.
void check_only(const Warnings& warnings, const std::string& code, Severity severity, const std::string& part) {
  CAPTURE(code);
  REQUIRE(warnings.size() == 1);
  CHECK(warnings[0].code == code);
  CHECK(warnings[0].severity == severity);
  INFO(warnings[0].text);
  CHECK(decid::test::contains(warnings[0].text, part));
}

}  // namespace

TEST_CASE("sway with a sensor's noise has no fault, at any rate and size of noise") {
  for (const double noise : {0.002, 0.02, 0.1}) CHECK(found(sway(noise)).empty());
  CHECK(found(sway(0.02), 50.0).empty());
  CHECK(found(sway(0.02), 1000.0).empty());
  CHECK(found(sway(0.0, 100)).empty());  // too short to tell
}

TEST_CASE("stretches that stand still are found, with their share") {
  std::vector<double> values = sway(0.02);
  for (std::size_t k = 1000; k < 1030; ++k) values[k] = values[1000];
  check_only(found(values), "frozen", Severity::info, "1 stretch, the longest 0.3 s, the first from 10 s on, 0.75%");
  for (std::size_t k = 2000; k < 2100; ++k) values[k] = values[2000];
  check_only(found(values), "frozen", Severity::caution, "2 stretches, the longest 1 s, the first from 10 s on, 3.25%");
  std::vector<double> rest = sway(0.02);
  for (std::size_t k = 0; k < 30; ++k) rest[k] = 0.0;
  check_only(found(rest), "jumps", Severity::caution, "");
  std::vector<double> held = sway(0.02);
  for (std::size_t k = 0; k < held.size(); ++k)
    held[k] = held[k - k % 2];  // a sensor of half the rate stands still by design
  for (const Warning& warning : found(held)) CHECK(warning.code != "frozen");
}

TEST_CASE("steps of a coarse sensor are found, and are no frozen stretches") {
  const auto rounded = [](double step) {
    std::vector<double> values = sway(0.02);
    for (double& value : values) value = step * std::round(value / step);
    return values;
  };
  check_only(found(rounded(0.05)), "coarse_steps", Severity::info, "steps of 0.05 degrees");
  check_only(found(rounded(0.2)), "coarse_steps", Severity::caution, "steps of 0.2 degrees");
  CHECK(found(rounded(0.01)).empty());
}

TEST_CASE("single wrong samples are found, at both ends too") {
  std::vector<double> values = sway(0.02);
  values[0] += 5.0;
  check_only(found(values), "spikes", Severity::caution, "the first sample is off by 5");
  values = sway(0.02);
  values[1500] -= 3.0;
  check_only(found(values), "spikes", Severity::caution, "a single sample is off by 3");
  values[2500] += 2.0;
  check_only(found(values), "spikes", Severity::caution, "2 single samples are off by up to 3");
  CHECK(contains(found(values).front().text, "the first at 15 s"));
  const auto at = [](std::size_t sample) {
    std::vector<double> wrong = sway(0.02);
    wrong[sample] += 1.0;
    return found(wrong);
  };
  check_only(at(1), "spikes", Severity::caution, "the first at 0.01 s");
  check_only(at(2), "spikes", Severity::caution, "the first at 0.02 s");
  check_only(at(3997), "spikes", Severity::caution, "the first at 40 s");
  check_only(at(3998), "spikes", Severity::caution, "a single sample is off by");
  check_only(at(3999), "spikes", Severity::caution, "a single sample is off by");
  for (const std::size_t before : {2U, 3U, 3997U, 3998U}) {  // a jump is not a single sample
    CAPTURE(before);
    std::vector<double> moved = sway(0.02);
    for (std::size_t k = 0; k < before; ++k) moved[k] += 1.0;
    for (const Warning& warning : found(moved)) CHECK(warning.code != "spikes");
  }
}

TEST_CASE("simulated sway has no single wrong samples") {
  const sim::Protocol protocol = sim::default_protocol();
  const sim::Simulator simulator(protocol.ideal());
  std::vector<double> values(static_cast<std::size_t>(protocol.samples()));
  for (const double noise_deg : {0.0, 0.002, 0.02}) {
    for (std::uint64_t item = 0; item < 12; ++item) {
      CAPTURE(noise_deg);
      CAPTURE(item);
      simulator.run(protocol.parameters().middle(), Random(1, sim::streams::vestibular_noise, item), values);
      const Random noise(2, sim::streams::sensor_noise, item);
      for (std::size_t k = 0; k < values.size(); ++k) values[k] += noise_deg * sim::rad_per_deg * noise.normal(k);
      for (const std::size_t samples : {values.size(), values.size() - item - 1}) {
        CHECK_FALSE(has(look_for_faults(std::span(values).first(samples), rate_hz).warnings, "spikes"));
      }
    }
  }
}

TEST_CASE("jumps to another level are found, at any rate; single samples and frozen sensors are none") {
  for (const double at_hz : {50.0, 100.0}) {
    CAPTURE(at_hz);
    std::vector<double> values = sway(0.02);
    for (std::size_t k = 2000; k < values.size(); ++k) values[k] += 2.0;
    check_only(found(values, at_hz), "jumps", Severity::caution, "jumps in 1 place, by up to");
    for (std::size_t k = 3000; k < 3200; ++k) values[k] -= 3.0;
    check_only(found(values, at_hz), "jumps", Severity::caution, "jumps in 3 places");
  }
  std::vector<double> occluded = sway(0.02);
  for (std::size_t k = 1500; k < 1530; ++k) occluded[k] = -7.0;
  const Warnings warnings = found(occluded);
  REQUIRE(warnings.size() == 2);
  CHECK(warnings[0].code == "frozen");
  CHECK(warnings[1].code == "jumps");
  CHECK(contains(warnings[1].text, "empty"));
  for (double& value : occluded) value = value == -7.0 ? 0.0 : value + 4.0;
  REQUIRE(found(occluded).size() == 2);
  CHECK(contains(found(occluded)[1].text, setting("missing") + " 0 and " + setting("fill_gaps") + " 0.3;"));
  std::vector<double> frozen = sway(0.02);
  for (std::size_t k = 1000; k < 1050; ++k) frozen[k] = frozen[1000];  // it goes on half a degree away
  for (const Warning& warning : found(frozen)) CHECK(warning.code != "jumps");
}

namespace {

/// The mean of `length` samples that end in each.
std::vector<double> averaged(const std::vector<double>& values, std::size_t length) {
  std::vector<double> means(values.size());
  for (std::size_t k = 0; k < values.size(); ++k)
    for (std::size_t i = 0; i < length; ++i) means[k] += values[k - std::min(i, k)] / static_cast<double>(length);
  return means;
}

}  // namespace

TEST_CASE("moving averages are found by the zeros of their spectrum, with their lengths, at any noise and rate") {
  for (const double noise : {0.002, 0.1})
    for (const auto& [length, text] : {std::pair<std::size_t, std::string>{5, "of 0.05 s"},
                                       {11, "of 0.11 s"},
                                       {25, "of 0.25 s"},
                                       {50, "of 0.5 s"},
                                       {100, "of 1 s"}}) {
      check_only(found(averaged(sway(noise, 12000), length)), "smooth",
                 length > 25 ? Severity::caution : Severity::info, text);
    }
  check_only(found(averaged(sway(0.1, 120'000), 500), 1000.0), "smooth", Severity::caution, "of 0.5 s");
  check_only(found(averaged(sway(0.1, 4000), 12), 25.0), "smooth", Severity::caution, "of 0.48 s");
  for (const double at_hz : {25.0, 50.0, 100.0, 1000.0}) CHECK(found(sway(0.02, 12000), at_hz).empty());
  // A pulse has such a spectrum too.
  std::vector<double> pulse = sway(0.002, 12000);
  for (std::size_t k = 4000; k < 4050; ++k) pulse[k] += 3.0;
  check_only(found(pulse), "jumps", Severity::caution, "");
}

TEST_CASE("values of a slow sensor that are held have no jumps by this; their rate is named") {
  // Faster than the sway of the other cases, so that each value differs clearly from the one before.
  const auto held = [](std::size_t every, std::size_t first, double noise_deg) {
    std::vector<double> values = sway(noise_deg, 12000);
    for (std::size_t k = 0; k < values.size(); ++k) values[k] *= 1.0 + 0.5 * std::sin(0.05 * static_cast<double>(k));
    for (std::size_t k = 0; k < values.size(); ++k)
      if ((k + every - first) % every != 0 && k > 0) values[k] = values[k - 1];
    return values;
  };
  for (const auto& [every, rate] : {std::pair{4U, "25 Hz"}, {5U, "20 Hz"}, {8U, "12.5 Hz"}, {10U, "10 Hz"}})
    for (const std::size_t first : {0U, 3U}) {
      const std::size_t period = every;
      CAPTURE(period);
      CAPTURE(first);
      check_only(found(held(every, first, 0.002)), "held_samples", Severity::info, rate);
      check_only(found(held(every, first, 0.02)), "held_samples", Severity::info, rate);
    }
  for (const std::size_t every : {12U, 16U, 20U})
    check_only(found(held(every, 0, 0.02)), "held_samples", Severity::caution, "lasts " + std::to_string(every));
  for (const std::size_t every : {21U, 25U, 30U})
    check_only(found(held(every, 0, 0.02)), "held_samples", Severity::invalid, "lasts " + std::to_string(every));
  // A jump of the sensor and a wrong value of it are found all the same.
  std::vector<double> jump = held(5, 0, 0.02), wrong = jump;
  for (std::size_t k = 6000; k < jump.size(); ++k) jump[k] += 4.0;
  CHECK(has(found(jump), "jumps"));
  for (std::size_t k = 6000; k < 6005; ++k) wrong[k] += 4.0;
  CHECK(has(found(wrong), "spikes"));
  // One sample that comes late: these are no equal runs.
  std::vector<double> late = held(5, 0, 0.02);
  late[7000] = late[6999];
  CHECK_FALSE(has(found(late), "held_samples"));
}

TEST_CASE("the moving average that smoothed a sway is known, so that a fit can undo it") {
  for (const std::size_t length : {11U, 18U, 50U}) {
    const std::optional<LowPass> filter =
        look_for_faults(averaged(sway(0.02, 12000), length), rate_hz, 0.0, 0.25).low_pass;
    REQUIRE(filter);
    CHECK(filter->averaged == static_cast<int>(length));
    CHECK(filter->rate_hz == rate_hz);
  }
  CHECK_FALSE(look_for_faults(sway(0.02, 12000), rate_hz, 0.0, 0.25).low_pass);
}

TEST_CASE("zeros of the tilt's spectrum are no moving average") {
  const std::vector<double> held = averaged(sway(0.02, 12000), 25);
  const auto warned = [](const std::vector<double>& values, double held_s) {
    return look_for_faults(values, rate_hz, 0.0, held_s).warnings;
  };
  CHECK(warned(held, 0.25).empty());
  check_only(warned(held, 0.2), "smooth", Severity::info, "of 0.25 s");
  check_only(warned(averaged(sway(0.02, 12000), 50), 0.25), "smooth", Severity::caution, "of 0.5 s");
}

TEST_CASE("sway without a sensor's noise was smoothed, or simulated") {
  check_only(found(sway(0.0)), "smooth", Severity::info, "no measurement noise");
  std::vector<double> values = sway(0.02), smooth = values;
  for (int pass = 0; pass < 4; ++pass)
    for (std::size_t k = 11; k < values.size(); ++k) {
      smooth[k] = 0.0;
      for (std::size_t i = 0; i < 11; ++i) smooth[k] += values[k - i] / 11.0;
      if (k + 1 == values.size()) values = smooth;
    }
  check_only(found(values), "smooth", Severity::info, "moving average of 0.11 s");
  for (const Warning& warning : found(sway(0.0), 20.0))
    CHECK(warning.code != "smooth");  // the rate is too low to judge
}

TEST_CASE("a low-pass that removes much is a caution") {
  const auto smoothed = [](double cutoff_hz) {  // Butterworth, first order, both ways
    std::vector<double> values = sway(0.1, 12000);
    const double warped = std::tan(sim::pi * cutoff_hz / rate_hz);
    for (int pass = 0; pass < 2; ++pass) {
      double in = values[0], out = in;
      for (double& value : values) {
        out = (warped * (value + in) + (1.0 - warped) * out) / (1.0 + warped);
        in = std::exchange(value, out);
      }
      std::ranges::reverse(values);
    }
    return values;
  };
  check_only(found(smoothed(1.0)), "smooth", Severity::caution, "leaves open");
  check_only(found(smoothed(10.0)), "smooth", Severity::info, "low-pass");
}

TEST_CASE("samples that were bridged by a straight line are found, unless the reader has filled gaps itself") {
  std::vector<double> values = sway(0.02);
  for (std::size_t k = 1001; k < 1061; ++k) values[k] = values[1000] + 0.004 * static_cast<double>(k - 1000);
  const Warnings bridged = found(values);
  REQUIRE(!bridged.empty());
  CHECK(bridged[0].code == "bridged");
  CHECK(bridged[0].severity == Severity::info);
  for (double& value : values) value *= sim::rad_per_deg;
  const auto bridges = [&](SampleRange known) {
    const Warnings warnings = look_for_faults(values, rate_hz, 0.0, 0.0, std::span(&known, 1)).warnings;
    return std::ranges::count(warnings, "bridged", &Warning::code);
  };
  CHECK(bridges({1001, 1061}) == 0);
  CHECK(bridges({500, 600}) == 1);
}
