// The part of a recording that is used: lengths that differ a little, starts between samples, and times before 0.
#include "recording/detail/placement.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "base/math/random.hpp"
#include "recording/detail/tilt/tilt_start.hpp"
#include "recording/trial.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"
#include "tests/recording/table/reading.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

/// A recording of noise.
Recording of_length(std::size_t samples) {
  const Random random(9, sim::streams::sensor_noise, 0);
  std::vector<double> sway;
  for (std::size_t k = 0; k < samples; ++k) sway.push_back(0.01 * random.normal(k));
  return make_recording(sway, 100.0);
}

}  // namespace

TEST_CASE("a clean tilt at any rate lacks no sample at its start") {
  const sim::Protocol protocol = sim::default_protocol();
  const std::vector<double> exact = prescribed_tilt(protocol);
  for (const double rate : {30.0, 60.0, 64.0, 120.0, 128.0, 148.0}) {
    CAPTURE(rate);
    Recording recording = of_length(2);
    std::vector<double> sway, tilt;
    for (std::size_t k = 0; k < static_cast<std::size_t>(121.0 * rate); ++k) {
      const double place = static_cast<double>(k) / rate * 100.0, below = std::min(std::floor(place), 12098.0);
      const auto i = static_cast<std::size_t>(below);
      tilt.push_back(exact[i] + (place - below) * (exact[i + 1] - exact[i]));
      sway.push_back(0.7 * tilt.back());
    }
    recording.rate_hz = rate;
    recording.signals.add({com_sway, "sway", sway});
    recording.signals.add({platform_tilt, "tilt", tilt});
    const Trial trial = bring_to_protocol(recording, protocol);
    CHECK(within(trial.tilt->delay_s, 0.0, 0.002));
    CHECK_FALSE(has(recording.warnings, "samples_lacking"));
    CHECK(within(trial.sway_rad()[0], 0.7 * exact[0], 2e-4));
  }
}

TEST_CASE("up to 0.1 s more or less at the end is a note, more is a caution") {
  const sim::Protocol protocol = sim::default_protocol();
  const auto severity = [&](std::size_t samples, const char* code) {
    Recording recording = of_length(samples);
    bring_to_protocol(recording, protocol);
    REQUIRE(warning(recording.warnings, code) != nullptr);
    return warning(recording.warnings, code)->severity;
  };
  CHECK(severity(12101, "part_not_used") == Severity::info);
  CHECK(severity(12110, "part_not_used") == Severity::info);
  CHECK(severity(12111, "part_not_used") == Severity::caution);
  CHECK(severity(12099, "samples_lacking") == Severity::info);
  CHECK(severity(12090, "samples_lacking") == Severity::info);
  CHECK(severity(12089, "samples_lacking") == Severity::caution);
}

TEST_CASE("a recording that lacks both ends has no whole cycle, and one that lacks the start has the second one") {
  const sim::Protocol protocol = sim::default_protocol();
  const std::vector<double> exact = prescribed_tilt(protocol);
  const auto message = [&](std::ptrdiff_t before, std::ptrdiff_t after) {
    const std::vector<double> tilt(exact.begin() + before, exact.end() - after);
    Recording recording = of_length(tilt.size());
    recording.file = "cut.csv";
    recording.signals.add({platform_tilt, "tilt", tilt});
    return message_of([&] { bring_to_protocol(recording, protocol); });
  };
  const std::string both = message(500, 300);
  CHECK(contains(both, "lacks the first 5 s and the last 3 s"));
  CHECK(contains(both, "none of the protocol's 2 cycles"));
  CHECK_FALSE(contains(both, "set its cycles"));  // no part of it is a cycle from the protocol's start
  const std::string begin = message(1000, 0);
  CHECK(contains(begin, "lacks the first 10 s"));
  CHECK(contains(begin, "set its cycles to 1"));
  CHECK(contains(message(0, 1000), "set its cycles to 1"));
  // All cycles, but not the rest before them.
  sim::Protocol rest_first = protocol;
  rest_first.sequence().lead_in_s = 10.0;
  std::vector<double> tilt(700, 0.0);
  tilt.insert(tilt.end(), exact.begin(), exact.end());
  Recording late = of_length(tilt.size());
  late.file = "late.csv";
  late.signals.add({platform_tilt, "tilt", tilt});
  CHECK(contains(message_of([&] { bring_to_protocol(late, rest_first); }), "lacks the first 3 s"));
}

TEST_CASE("a recording that fits the protocol in minutes is asked for the unit of its times") {
  const sim::Protocol protocol = sim::default_protocol();
  const auto message = [&](double rate_hz) {
    Recording recording = of_length(12100);
    recording.file = "minutes.csv";
    recording.rate_hz = rate_hz;
    return message_of([&] { bring_to_protocol(recording, protocol); });
  };
  CHECK(contains(message(6000.0), "time_min"));
  CHECK_FALSE(contains(message(1000.0), "time_min"));
}

TEST_CASE("times that begin before 0 are named with the start, and make it doubtful") {
  const sim::Protocol protocol = sim::default_protocol();
  const auto from = [&](int first, int samples, const TrialOptions& options = {}) {
    const Recording noise = of_length(static_cast<std::size_t>(samples));
    std::string text = "time,com_sway_deg\n";
    char row[64];
    for (int k = 0; k < samples; ++k) {
      std::snprintf(row, sizeof row, "%.2f,%.5f\n", (first + k) / 100.0,
                    noise.signals.at(com_sway).rad[static_cast<std::size_t>(k)] / sim::rad_per_deg);
      text += row;
    }
    Recording recording = read(text);
    const Trial trial = bring_to_protocol(recording, protocol, options);
    return std::pair{recording.warnings, trial.start_is_doubtful};
  };
  const auto [early, is_doubtful] = from(-3000, 15100);
  REQUIRE(warning(early, "starts_before_zero") != nullptr);
  CHECK(contains(warning(early, "starts_before_zero")->text, "begin 30 "));
  CHECK(is_doubtful);
  for (const double start_s : {0.0, 30.0}) {
    const auto [given, is_open] = from(-3000, 15100, {.start_s = start_s});
    CHECK(warning(given, "starts_before_zero") == nullptr);
    CHECK_FALSE(is_open);
  }
  CHECK(warning(from(0, 15100).first, "starts_before_zero") == nullptr);
  CHECK(warning(from(500, 15100).first, "starts_before_zero") == nullptr);
  CHECK(warning(from(-3000, 12100).first, "starts_before_zero") == nullptr);  // too short after time 0
  // The start of a file as long as the protocol is clear; --begin 1 would lack a second.
  for (const int samples : {12090, 12100, 12110}) {
    CAPTURE(samples);
    const auto [whole, is_unclear] = from(-100, samples);
    CHECK(warning(whole, "starts_before_zero") == nullptr);
    CHECK_FALSE(is_unclear);
  }
  CHECK(warning(from(-100, 12150).first, "starts_before_zero") == nullptr);  // lacks half a second after time 0
  CHECK(warning(from(-100, 12150).first, "part_not_used") != nullptr);
  // One caution names the part that is not used and time 0; a sample less after time 0 is as good.
  for (const int samples : {12599, 12600}) {
    CAPTURE(samples);
    const Warnings longer = from(-500, samples).first;
    REQUIRE(warning(longer, "starts_before_zero") != nullptr);
    CHECK(contains(warning(longer, "starts_before_zero")->text, "begin 5 "));
    CHECK(contains(warning(longer, "starts_before_zero")->text, samples == 12600 ? "the last 5 s" : "the last 4.99 s"));
    CHECK(warning(longer, "part_not_used") == nullptr);
  }
}
