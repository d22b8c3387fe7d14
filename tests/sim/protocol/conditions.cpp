// Tests of sim/protocol/conditions.hpp: each condition by what it does to a known signal, how often and how much it is
// drawn, its JSON and bounds, and the bits of all of them together.
#include "sim/protocol/conditions.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <string>
#include <vector>

#include "base/files/sha256.hpp"
#include "base/math/random.hpp"
#include "sim/noise.hpp"
#include "sim/protocol/protocol_json.hpp"
#include "tests/helpers.hpp"

using namespace decid::sim;
using decid::Code;
using namespace decid::test;

namespace {

constexpr double rate_hz = 100.0;
constexpr std::uint64_t seed = 7;

/// The default protocol with one condition, of every trial.
Protocol with(Condition condition, double low, double high, double fraction = 1.0) {
  Protocol protocol;
  protocol.conditions[condition] = {fraction, low, high};
  protocol.validate();
  return protocol;
}

std::vector<double> recorded(const Protocol& protocol, std::vector<double> sway, std::uint64_t item = 3) {
  record(protocol, seed, item, sway);
  return sway;
}

std::vector<double> sine(double hz, double samples_later = 0.0) {
  std::vector<double> all(12'100);
  for (std::size_t i = 0; i < all.size(); ++i)
    all[i] = 0.01 * std::sin(2.0 * pi * hz * (static_cast<double>(i) + samples_later) / rate_hz);
  return all;
}

std::vector<double> line() {
  std::vector<double> all(12'100);
  std::iota(all.begin(), all.end(), 0.0);
  return all;
}

/// Over whole seconds in the middle.
double amplitude(const std::vector<double>& sway, double hz) {
  double sin = 0.0, cos = 0.0;
  for (std::size_t i = 2000; i < 10'000; ++i) {
    const double angle = 2.0 * pi * hz * static_cast<double>(i) / rate_hz;
    sin += sway[i] * std::sin(angle) / 4000.0;
    cos += sway[i] * std::cos(angle) / 4000.0;
  }
  return std::hypot(sin, cos);
}

}  // namespace

TEST_CASE("record: without conditions the sensor's noise alone") {
  Protocol protocol;
  const std::vector<double> exact = sine(0.3);
  CHECK(recorded(protocol, exact) == exact);
  protocol.noise.sensor = {0.02, 0.02};
  std::vector<double> noisy = exact;
  add_sensor_noise(protocol.noise.sensor, seed, 3, noisy);
  CHECK(recorded(protocol, exact) == noisy);
}

TEST_CASE("drawn: as often and as large as the protocol says, each condition by itself") {
  const Protocol protocol = with(Condition::drift, 0.1, 1.0, 0.3);
  Protocol others = protocol;
  others.conditions[Condition::gain] = {0.5, 0.0, 0.2};
  int present = 0, negative = 0, below_root = 0;
  constexpr int trials = 20'000;
  for (std::uint64_t item = 0; item < trials; ++item) {
    const double drift = drawn(protocol.conditions, Condition::drift, seed, item);
    CHECK(drawn(others.conditions, Condition::drift, seed, item) == drift);
    CHECK(drawn(protocol.conditions, Condition::offset, seed, item) == 0.0);
    if (drift == 0.0) continue;
    ++present;
    negative += drift < 0.0 ? 1 : 0;
    below_root += std::abs(drift) < std::sqrt(0.1) ? 1 : 0;
    CHECK(std::abs(drift) >= 0.1);
    CHECK(std::abs(drift) <= 1.0);
  }
  // Five deviations of a binomial count: a false alarm in 1.7 million.
  CHECK(std::abs(present - 0.3 * trials) < 5.0 * std::sqrt(0.3 * 0.7 * trials));
  CHECK(std::abs(negative - 0.5 * present) < 2.5 * std::sqrt(present));
  CHECK(std::abs(below_root - 0.5 * present) < 2.5 * std::sqrt(present));
  // From 0: uniform, of both signs.
  const Conditions gains = with(Condition::gain, 0.0, 0.2).conditions;
  double squares = 0.0;
  for (std::uint64_t item = 0; item < trials; ++item)
    squares += std::pow(drawn(gains, Condition::gain, seed, item), 2) / trials;
  CHECK(near(squares, 0.04 / 3.0, 5.0 * std::sqrt(0.8 / trials)));
}

TEST_CASE("record: start, gain, offset and drift") {
  for (std::uint64_t item = 0; item < 8; ++item) {
    const Protocol late = with(Condition::start, 0.0, 0.1);
    const double samples = rate_hz * drawn(late.conditions, Condition::start, seed, item);
    const std::vector<double> shifted = recorded(late, sine(0.5), item), expected = sine(0.5, samples);
    // Error of a cubic through four samples: h^4 / 24 * 9/16 of the fourth derivative.
    const double step = 2.0 * pi * 0.5 / rate_hz, bound = 0.01 * std::pow(step, 4) / 24.0;
    for (std::size_t i = 20; i < 12'000; ++i) CHECK(std::abs(shifted[i] - expected[i]) < bound);
    if (samples < -3.0) CHECK(shifted[0] == 0.0);  // at rest before
    std::vector<double> alone = sine(0.5);
    begin_later(alone, samples);
    CHECK(alone == shifted);
  }
  // A body that has stood before moves at both ends: w^3 t^3 / 6 of a sine, t a tenth of a second at most.
  for (std::uint64_t item = 0; item < 8; ++item) {
    Protocol late = with(Condition::start, 0.0, 0.1);
    late.standing_s = 10.0;
    const double samples = rate_hz * drawn(late.conditions, Condition::start, seed, item);
    const std::vector<double> shifted = recorded(late, sine(0.5), item), expected = sine(0.5, samples);
    const double bound = 0.01 * std::pow(2.0 * pi * 0.5 * (std::abs(samples) + 3.0) / rate_hz, 3) / 6.0;
    for (std::size_t i = 0; i < expected.size(); ++i) REQUIRE(std::abs(shifted[i] - expected[i]) < bound);
  }
  const std::vector<double> exact = sine(0.3);
  const Protocol gain = with(Condition::gain, 0.3, 0.3);
  const Protocol offset = with(Condition::offset, 2.0, 2.0), drift = with(Condition::drift, 1.0, 1.0);
  for (std::uint64_t item = 0; item < 4; ++item) {
    const double factor = 1.0 + drawn(gain.conditions, Condition::gain, seed, item);
    CHECK((factor == 1.3 || factor == 0.7));
    const double by = drawn(offset.conditions, Condition::offset, seed, item) * rad_per_deg;
    const double end = drawn(drift.conditions, Condition::drift, seed, item) * rad_per_deg;
    const auto scaled = recorded(gain, exact, item), moved = recorded(offset, exact, item),
               tilted = recorded(drift, exact, item);
    CHECK(scaled[777] == exact[777] * factor);
    CHECK(moved[777] == exact[777] + by);
    CHECK(tilted[0] == exact[0]);
    CHECK(near(tilted[12'099] - exact[12'099], end, 1e-9));
  }
}

TEST_CASE("record: slow noise has its deviation, and little of it is fast") {
  const Protocol protocol = with(Condition::slow_noise, 0.1, 0.1);
  double variance = 0.0, of_steps = 0.0;
  constexpr int trials = 400;
  for (std::uint64_t item = 0; item < trials; ++item) {
    const std::vector<double> noise = recorded(protocol, std::vector<double>(12'100), item);
    for (std::size_t i = 0; i < noise.size(); i += 100) variance += noise[i] * noise[i] / 121.0 / trials;
    for (std::size_t i = 10; i < noise.size(); i += 10)
      of_steps += std::pow(noise[i] - noise[i - 10], 2) / 1209.0 / trials;
  }
  // Memories of 1 to 30 s: 2 of 121 s to 60 independent values a trial, 10 at least in the mean of their inverses.
  const double expected = std::pow(0.1 * rad_per_deg, 2);
  CHECK(std::abs(variance / expected - 1.0) < 5.0 * std::sqrt(2.0 / (10.0 * trials)));
  // A step of 0.1 s has 2 (1 - exp(-0.1 / memory)) of the variance: 0.19 at most.
  CHECK(of_steps < 0.19 * expected);
  CHECK(of_steps > 0.0066 * expected);
}

TEST_CASE("record: frozen and lost stretches, one in every 10 s") {
  const std::vector<double> exact = sine(0.31);
  const std::vector<double> frozen = recorded(with(Condition::frozen, 0.3, 0.3), exact);
  const std::vector<double> lost = recorded(with(Condition::lost, 0.3, 0.3), exact);
  int frozen_samples = 0, lost_samples = 0;
  std::vector<int> in_stretch(13, 0);
  for (std::size_t i = 1; i < exact.size(); ++i) {
    if (frozen[i] != exact[i]) {
      CHECK(frozen[i] == frozen[i - 1]);
      ++frozen_samples;
      ++in_stretch[(i - 1) / 1000];
    }
    if (lost[i] != exact[i]) {
      ++lost_samples;
      CHECK(near(lost[i + 1] - lost[i], lost[i] - lost[i - 1], 1e-12));
    }
  }
  // The last stretch is 1 s long. A frozen value may by chance be right.
  CHECK(frozen_samples <= 13 * 30);
  CHECK(frozen_samples >= 12 * 29);
  CHECK(lost_samples == 13 * 30);
  const std::vector<double> single = recorded(with(Condition::lost, 0.01, 0.01), exact);
  CHECK(std::ranges::mismatch(single, exact).in1 != single.end());  // a gap of one sample
  for (int stretch = 0; stretch < 12; ++stretch) CHECK(in_stretch[static_cast<std::size_t>(stretch)] >= 29);
}

TEST_CASE("record: moving averages, causal and centred") {
  const Protocol protocol = with(Condition::average, 0.11, 0.11);
  std::set<double> lags;
  for (std::uint64_t item = 0; item < 12; ++item) {
    const std::vector<double> averaged = recorded(protocol, line(), item);
    const double lag = 5000.0 - averaged[5000];
    lags.insert(lag);
    for (std::size_t i = 100; i < 12'000; ++i) CHECK(near(averaged[i], static_cast<double>(i) - lag, 1e-9));
  }
  CHECK(lags == std::set<double>{0.0, 5.0});
  const double of_two = amplitude(recorded(with(Condition::average, 0.02, 0.02), sine(8.0)), 8.0);
  CHECK(near(of_two / 0.01, std::cos(pi * 0.08), 1e-6));
}

TEST_CASE("record: low-passes are Butterworth's") {
  // Warping by the bilinear transform moves 4 Hz and below by less than 0.6 % of itself at 100 Hz.
  const Protocol protocol = with(Condition::low_pass, 4.0, 4.0);
  std::set<int> orders, causal_orders;
  for (std::uint64_t item = 0; item < 60; ++item) {
    const double at_cutoff = amplitude(recorded(protocol, sine(4.0), item), 4.0) / 0.01;
    const bool causal = at_cutoff > 0.6;
    CHECK(near(at_cutoff, causal ? std::sqrt(0.5) : 0.5, 1e-9));
    const double at_twice = amplitude(recorded(protocol, sine(8.0), item), 8.0) / 0.01;
    const double one_pass = causal ? at_twice : std::sqrt(at_twice);
    // 1 / sqrt(1 + (tan(pi f / rate) / tan(pi cutoff / rate))^(2 order))
    const double ratio = std::tan(pi * 0.08) / std::tan(pi * 0.04);
    const double order = std::log(1.0 / (one_pass * one_pass) - 1.0) / std::log(ratio) / 2.0;
    CHECK(near(order, std::round(order), 1e-6));
    (causal ? causal_orders : orders).insert(static_cast<int>(std::lround(order)));
    const std::vector<double> constant = recorded(protocol, std::vector<double>(12'100, 0.02), item);
    for (const double value : constant) CHECK(near(value, 0.02, 1e-9));
  }
  CHECK(orders == std::set<int>{1, 2, 4});
  CHECK(causal_orders == std::set<int>{1, 2, 4});
}

TEST_CASE("record: quantised") {
  const std::vector<double> exact = sine(0.31);
  const std::vector<double> rounded = recorded(with(Condition::quantisation, 0.1, 0.1), exact);
  for (std::size_t i = 0; i < exact.size(); ++i) {
    const double steps = rounded[i] / (0.1 * rad_per_deg);
    CHECK(near(steps, std::round(steps), 1e-9));
    CHECK(std::abs(rounded[i] - exact[i]) <= 0.05 * rad_per_deg * (1.0 + 1e-9));
  }
}

TEST_CASE("record: golden: the bits of all conditions together") {
  Protocol protocol;
  protocol.noise.sensor = {0.02, 0.02};
  const double sizes[condition_count] = {0.1, 0.1, 1.0, 0.5, 0.05, 0.3, 0.3, 0.1, 4.0, 0.01};
  for (std::size_t c = 0; c < condition_count; ++c) protocol.conditions.severity[c] = {1.0, 0.5 * sizes[c], sizes[c]};
  protocol.validate();
  std::string bytes;
  for (std::uint64_t item = 0; item < 12; ++item) {
    std::vector<double> sway(12'100);
    for (std::size_t i = 0; i < sway.size(); ++i) sway[i] = 1e-5 * static_cast<double>(i * i % 4000);
    sway = recorded(protocol, sway, item);
    CHECK(std::ranges::all_of(sway, [](double value) { return std::isfinite(value); }));
    bytes.append(reinterpret_cast<const char*>(sway.data()), sway.size() * sizeof(double));
  }
  CHECK(decid::sha256(bytes) == "f4524a94d49a1fc647773695ba8a81d5d38be86d601c96f128ce09e5f389adff");
}

TEST_CASE("conditions in protocol files") {
  const std::string text =
      R"({"recording": {"start_s": {"share": 0.5, "size": [0, 0.1]}, "low_pass_hz": {"size": 5}}})";
  const Protocol protocol = protocol_from_json(text, "my.json");
  const Severity& start = protocol.conditions[Condition::start];
  CHECK(start.fraction == 0.5);
  CHECK(start.low == 0.0);
  CHECK(start.high == 0.1);
  const Severity& low_pass = protocol.conditions[Condition::low_pass];
  CHECK(low_pass.fraction == 1.0);
  CHECK(low_pass.low == 5.0);
  CHECK(low_pass.high == 5.0);
  CHECK(protocol.conditions[Condition::gain].fraction == 0.0);
  CHECK(to_json(protocol_from_json(to_json(protocol), "again")) == to_json(protocol));
  CHECK_FALSE(contains(to_json(Protocol{}), "recording"));
  std::set<std::string> keys;
  for (std::size_t c = 0; c < condition_count; ++c) keys.insert(info(static_cast<Condition>(c)).key);
  CHECK(keys.size() == condition_count);

  const auto refused = [](const std::string& inner, Code code, std::string_view fact = {}) {
    check_error([&] { protocol_from_json(R"({"recording": {)" + inner + "}}", "my.json"); }, code, fact);
  };
  refused(R"("wind": {"size": 1})", Code::setting_unknown, "wind");
  refused(R"("gain": 0.1)", Code::setting_malformed, "recording.gain");
  refused(R"("gain": {"share": 0.1})", Code::setting_missing, "size");
  refused(R"("gain": {"size": "big"})", Code::setting_malformed, "size");
  refused(R"("gain": {"size": [0.2, 0.1]})", Code::setting_out_of_range, "my.json");
  refused(R"("gain": {"size": 1.5})", Code::setting_out_of_range, "1.5");
  refused(R"("gain": {"size": 0.1, "share": 1.5})", Code::setting_out_of_range, "1.5");
  refused(R"("gain": {"size": 0.1, "often": 1})", Code::setting_unknown, "often");
  refused(R"("low_pass_hz": {"size": [0, 3]})", Code::setting_out_of_range, "low_pass_hz");
}
