// Uneven times, lost samples and gaps: what is corrected, what is reported, and what is refused.
#include "recording/detail/clock.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <map>

#include "base/math/random.hpp"
#include "base/setting.hpp"
#include "base/text.hpp"
#include "sim/streams.hpp"
#include "tests/recording/table/reading.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

/// A sine of 1 degree, 1 Hz, at the times given.
std::string sine_at(const std::vector<double>& times, const char* format = "%.9f,%.9f\n") {
  std::string text = "time,sway_deg\n";
  char line[64];
  for (const double t : times) {
    std::snprintf(line, sizeof line, format, t, std::sin(2.0 * sim::pi * t));
    text += line;
  }
  return text;
}

/// Largest difference from that sine, in degrees; of all samples, or without some at either end.
double stddev(const Recording& recording, std::size_t margin = 0) {
  double largest = 0.0;
  for (std::size_t k = margin; k + margin < recording.signals.at(com_sway).rad.size(); ++k) {
    const double exact = std::sin(2.0 * sim::pi * static_cast<double>(k) / recording.rate_hz);
    largest = std::max(largest, std::abs(recording.signals.at(com_sway).rad[k] / sim::rad_per_deg - exact));
  }
  return largest;
}

}  // namespace

TEST_CASE("jitter is interpolated by cubics, and reported") {
  const Random random(3, sim::streams::sensor_noise, 1);
  std::vector<double> times;
  for (std::size_t k = 0; k <= 1000; ++k) {
    // 3 to 12% of a sample early or late: none is taken as it is.
    const double apart = k == 0 || k == 1000 ? 0.0 : random.uniform(2 * k, 0.03, 0.12);
    times.push_back(0.01 * (static_cast<double>(k) + (random.uniform(2 * k + 1) < 0.5 ? -apart : apart)));
  }
  const Recording recording = read(sine_at(times));
  CHECK(recording.rate_hz == 100.0);
  CHECK(recording.signals.samples() == 1001);
  CHECK(has(recording.warnings, "uneven_times"));
  // (2 pi / 100)^4 3 / 128 = 4e-7, twice that for uneven points; a straight line would be 1e-4 away. The first and last
  // have no neighbours beyond.
  CHECK(stddev(recording, 2) < 8e-7);
}

TEST_CASE("times rounded to milliseconds are an even grid") {
  std::vector<double> times;
  for (int k = 0; k < 1200; ++k) times.push_back(k / 120.0);
  const Recording recording = read(sine_at(times, "%.3f,%.9f\n"));
  CHECK(recording.rate_hz == 120.0);
  CHECK(worst_trust(recording.warnings) == Trust::usable);
  CHECK(stddev(recording) < 1e-8);
}

TEST_CASE("lost samples are gaps: filled when they may be, else refused with their place") {
  std::vector<double> times;
  for (int k = 0; k < 500; ++k) {
    if (k != 100 && !(k >= 300 && k < 304)) times.push_back(k / 100.0);
  }
  check_error([&] { read(sine_at(times)); }, Code::value_missing, "fill_gaps");
  check_error([&] { read(sine_at(times), {.fill_gaps_s = 0.03}); }, Code::value_missing, "fill_gaps");
  const Recording recording = read(sine_at(times), {.fill_gaps_s = 0.04});
  CHECK(recording.rate_hz == 100.0);
  REQUIRE(recording.signals.at(com_sway).rad.size() == 500);
  // A straight line over 0.05 s: (2 pi 0.05)^2 / 8 = 0.0123 degrees at most.
  CHECK(stddev(recording) < 0.0124);
  CHECK(warns(recording, "5 missing values of sway_deg in 2 gaps, the longest 0.04 s, are interpolated (1% of"));
}

TEST_CASE("rows that are exact copies are dropped, other rows of the same time and blocks that come twice are not") {
  const std::vector<std::string> rows = {"0,1,a\n", "0.01,2,b\n", "0.02,3,c\n", "0.03,4,d\n"};
  const std::string header = "time,sway_deg,note\n";
  for (const std::optional<double> rate_hz : {std::optional<double>(), std::optional(100.0)}) {
    const Recording recording =
        read(header + rows[0] + rows[1] + rows[1] + rows[1] + rows[2] + rows[3] + rows[3], {.rate_hz = rate_hz});
    CHECK(recording.rate_hz == 100.0);
    CHECK(recording.signals.samples() == 4);
    CHECK(has(recording.warnings, "copied_rows"));
    CHECK(warns(recording, "3 rows equal the row before them, time included (the first is line 4)"));
    CHECK(worst_trust(recording.warnings) == Trust::usable);
  }
  CHECK(warns(read(header + rows[0] + rows[1] + rows[2] + rows[2] + rows[3]), "1 row equals the row before it"));
  // Another value in any column.
  for (const char* other : {"0.01,2.5,b\n", "0.01,2,e\n"})
    check_error([&] { read(header + rows[0] + rows[1] + other + rows[2] + rows[2] + rows[3]); }, Code::times_uneven,
                "line 4");
  // A missing value equals a missing value; the line of a later fault is the file's.
  check_error([&] { read(header + rows[0] + rows[0] + "0.01,,\n0.01,,\n" + rows[2]); }, Code::value_missing, "line 4");
  const std::string trials =
      "trial,time,sway_deg\n1,0,1\n1,0.01,2\n1,0.02,3\n2,0,1\n2,0,1\n2,0.01,2\n2,0.02,\n2,0.03,3\n";
  check_error([&] { read(trials, {.trial_column = "trial", .trial = "2"}); }, Code::value_missing, "line 8");
  std::string block;
  for (int k = 0; k < 30; ++k) block += std::to_string(k) + "e-2," + std::to_string(k % 4) + ",x\n";
  check_error([&] { read(header + block + block); }, Code::recording_ambiguous, "line 32");
}

TEST_CASE("missing cells are gaps, in the middle and at the ends") {
  const auto text = [](const std::string& a, const std::string& b, const std::string& c) {
    return "time,sway_deg\n0," + a + "\n0.01,1\n0.02," + b + "\n0.03,3\n0.04," + c + "\n";
  };
  check_error([&] { read(text("0", "", "4")); }, Code::value_missing, "line 4, sway_deg");
  check_error([&] { read(text("0", "NaN", "4")); }, Code::value_missing, "line 4");
  // The error counts the gaps and gives the number that fills them all.
  const std::string gaps = "time,sway_deg\n0,0\n0.01,\n0.02,2\n0.03,\n0.04,nan\n0.05,\n0.06,6\n0.07,7\n0.09,8\n0.1,9\n";
  const Error refused = error_of([&] { read(gaps); });
  CHECK(refused.code() == Code::value_missing);
  for (const char* fact : {"line 3, sway_deg", " 1 sample (0.01 s)", "3 gaps of 5 samples", "3 samples (0.03 s)"})
    CHECK(contains(refused.problem(), fact));
  CHECK(contains(refused.remedy(), setting("fill_gaps") + " 0.03 "));
  CHECK_NOTHROW(read(gaps, {.fill_gaps_s = 0.03}));
  CHECK_FALSE(contains(refused.remedy(), "paused"));
  std::string paused = "time,sway_deg\n";
  for (int k = 0; k < 400; ++k) paused += std::to_string(0.1 * k + (k < 200 ? 0.0 : 20.0)) + ",1\n";
  const Error pause = error_of([&] { read(paused); });
  CHECK(contains(pause.remedy(), "if the platform paused"));
  // A lost row has no place in the file.
  check_error([&] { read("time,sway_deg\n0,0\n0.01,1\n0.03,3\n0.04,4\n0.05,\n0.06,6\n"); }, Code::value_missing,
              "2 gaps of 2 samples");
  check_error([&] { read(text("0", "inf", "4"), {.fill_gaps_s = 1.0}); }, Code::value_invalid, "line 4");
  const Recording recording = read(text("", "n/a", "nan"), {.fill_gaps_s = 0.01});
  const double expected[] = {1.0, 1.0, 2.0, 3.0, 3.0};
  REQUIRE(recording.signals.at(com_sway).rad.size() == 5);
  for (std::size_t k = 0; k < 5; ++k) {
    CHECK(near(recording.signals.at(com_sway).rad[k] / sim::rad_per_deg, expected[k], 1e-15));
  }
  CHECK(warns(recording, "3 missing values of sway_deg in 3 gaps"));
  check_error([] { read("time,sway\n0,\n0.01,\n", {.fill_gaps_s = 1.0}); }, Code::value_missing);
}

TEST_CASE("signals in rows of their own, as logs of several topics have them, are read at their own times") {
  // Sway at 100 Hz, a tilt at 40 Hz from 3 ms on, and a third signal that shares the tilt's rows now and then.
  const auto sway_at = [](double t) { return std::sin(2.0 * sim::pi * t); };
  const auto tilt_at = [](double t) { return 0.5 * std::sin(2.0 * sim::pi * 0.3 * t); };
  const auto log_of = [&](bool has_holes) {
    std::map<double, std::array<std::string, 3>> rows;
    const auto shown = [](double value) { return format("%.9f", value); };
    for (int k = 0; k < 1000; ++k)
      if (!has_holes || k % 100 < 90) rows[0.01 * k][0] = shown(sway_at(0.01 * k));
    for (int k = 0; k < 400; ++k) rows[0.003 + 0.025 * k][1] = shown(tilt_at(0.003 + 0.025 * k));
    for (int k = 0; k < 100; ++k) rows[0.003 + 0.1 * k][2] = "1";
    std::string text = "time,sway_deg,platform_deg,state\n";
    for (const auto& [time, cells] : rows)
      text += format("%.9f,", time) + cells[0] + "," + cells[1] + "," + cells[2] + "\n";
    return text;
  };
  const Recording recording = read(log_of(false));
  CHECK(has(recording.warnings, "separate_rows"));
  CHECK_FALSE(has(recording.warnings, "gaps_filled"));
  CHECK_FALSE(has(recording.warnings, "uneven_times"));
  CHECK(recording.rate_hz == 100.0);
  CHECK(stddev(recording) < 1e-8);
  const std::vector<double>& tilt = recording.signals.at(platform_tilt).rad;
  REQUIRE(tilt.size() == 1000);
  double largest = 0.0;
  for (std::size_t k = 1; k < 990; ++k)
    largest = std::max(largest, std::abs(tilt[k] / sim::rad_per_deg - tilt_at(0.01 * static_cast<double>(k))));
  CHECK(largest < 0.5 * std::pow(2.0 * sim::pi * 0.3 * 0.025, 2.0) / 8.0 + 1e-8);  // of a straight line
  // Samples that the log lost are gaps as in any other table.
  check_error([&] { read(log_of(true)); }, Code::value_missing);
  CHECK(read(log_of(true), {.fill_gaps_s = 0.2}).gaps.size() == 9);
  // One rate does not fit rows of several signals.
  check_error([&] { read(log_of(false), {.rate_hz = 100.0}); }, Code::times_uneven, "leave out");
  // A flag of missing samples is no signal, nor is one whose rounded times say nothing about its place.
  for (const bool is_flag : {true, false}) {
    std::string flagged = "time,sway_deg,other\n";
    for (int k = 0; k < 1000; ++k) {
      const bool missing = k % 100 < 10;
      const double time = is_flag || !missing ? 0.01 * k : 0.01 * (k - k % 100);
      flagged += format("%.2f,", time) + (missing ? "" : format("%.6f", sway_at(0.01 * k))) + "," +
                 (missing ? format("%d", is_flag ? 1 : k) : "") + "\n";
    }
    if (!is_flag) {
      check_error([&] { read(flagged, {.fill_gaps_s = 0.2}); }, Code::times_uneven);
      continue;
    }
    const Recording whole = read(flagged, {.fill_gaps_s = 0.2});
    CHECK_FALSE(has(whole.warnings, "separate_rows"));
    CHECK(whole.signals.at(com_sway).rad.size() == 1000);
  }
  // Two parts of the sway need common rows.
  std::string parts = "time,leg_deg,trunk_deg\n";
  for (int k = 0; k < 300; ++k)
    parts += format("%.2f,%.6f,\n%.3f,,%.6f\n", 0.01 * k, sway_at(0.01 * k), 0.01 * k + 0.005, sway_at(0.01 * k));
  check_error([&] { read(parts, {.leg_column = "leg_deg", .trunk_column = "trunk_deg"}); }, Code::times_uneven,
              "leg_deg, trunk_deg");
  // A signal in the sway's rows does not explain rows without sway.
  std::string text = "time,sway_deg,load\n";
  for (int k = 0; k < 300; ++k)
    text += format("%.2f,%s,7\n", 0.01 * k, k % 2 == 0 ? format("%.6f", sway_at(0.01 * k)).c_str() : "");
  check_error([&] { read(text); }, Code::value_missing);
}

TEST_CASE("no clock's times are refused") {
  // Farther away than any recording is long: found by fuzzing.
  for (const char* far : {"1e9", "1e30", "1e300"})
    check_error([&] { read("time,sway_deg\n0,1\n0.01,2\n0.02,3\n" + std::string(far) + ",4\n", {.fill_gaps_s = 1.0}); },
                Code::times_uneven, "line 5");
  std::vector<double> times{0.0, 0.01, 0.02, 0.0345, 0.04, 0.05};
  check_error([&] { read(sine_at(times)); }, Code::times_uneven, "line 5");
  times[3] = 0.015;
  check_error([&] { read(sine_at(times)); }, Code::times_uneven, "line 5");
  // Few uneven steps among many even ones are no clock without a grid.
  times.clear();
  for (int k = 0; k < 500; ++k) times.push_back(0.01 * k + (k < 100 ? 0.0 : 0.004));
  check_error([&] { read(sine_at(times)); }, Code::times_uneven, "line 102");
  // Among uneven times the one that goes backwards is the fault, not the first step of another length.
  times.clear();
  for (int k = 0; k < 500; ++k) times.push_back(0.01 * k + (k % 3 == 1 ? 0.003 : 0.0));
  times[400] = times[399] - 0.001;
  check_error([&] { read(sine_at(times)); }, Code::times_uneven, "line 402");
}

namespace {

/// Times whose steps are one of these, in ms.
std::vector<double> times_of_steps(const std::vector<double>& steps_ms, std::size_t count) {
  const Random random(4, sim::streams::sensor_noise, 0);
  std::vector<double> times{0.0};
  for (std::size_t k = 1; k < count; ++k) {
    const auto i = static_cast<std::size_t>(random.uniform(k) * static_cast<double>(steps_ms.size()));
    times.push_back(times.back() + 1e-3 * steps_ms[i]);
  }
  return times;
}

}  // namespace

TEST_CASE("times without a grid, as headsets and webcams have them, are interpolated") {
  // A headset at some 90 Hz: mean step 12.9 ms.
  const std::vector<double> headset = times_of_steps({8.4, 9.0, 10.9, 11.1, 12.3, 17.2, 22.4}, 2000);
  const Recording fast = read(sine_at(headset));
  const double rate = 1999.0 / headset.back();
  CHECK(near(fast.rate_hz, rate, 1e-9));
  CHECK(fast.signals.at(com_sway).rad.size() == 2000);
  // Cubics over steps of up to 22.4 ms err by (2 pi 0.0224)^4 3 / 128 = 9e-6; times within 1% of a sample move the sine
  // by 2 pi 0.01 / 77 = 8e-4.
  CHECK(stddev(fast, 2) < 1e-3);
  CHECK(warning(fast.warnings, "uneven_times")->severity == Severity::info);

  // A webcam of 30 frames a second that drops some: straight lines would err by (2 pi 0.066)^2 / 8 = 2e-2.
  const Recording slow = read(sine_at(times_of_steps({30, 33, 33, 33, 36, 40, 66}, 1000)));
  CHECK(slow.rate_hz > 25.0);
  CHECK(stddev(slow, 2) < 4e-3);

  // A gap in them is a gap, at the right place: 0.5 s after the 500th sample.
  std::vector<double> stopped = times_of_steps({30, 33, 36}, 1000);
  for (std::size_t k = 500; k < 1000; ++k) stopped[k] += 0.5;
  check_error([&] { read(sine_at(stopped)); }, Code::value_missing, "sway_deg");
  const Recording filled = read(sine_at(stopped), {.fill_gaps_s = 0.6});
  CHECK(near(filled.rate_hz, 999.0 / (stopped.back() - 0.5), 2e-3));
  const auto after = static_cast<std::size_t>(stopped[600] * filled.rate_hz);
  const double exact = std::sin(2.0 * sim::pi * static_cast<double>(after) / filled.rate_hz);
  CHECK(within(filled.signals.at(com_sway).rad[after] / sim::rad_per_deg, exact, 4e-3));
}

TEST_CASE("samples far apart make interpolated times a caution, and close ones no swing") {
  const Recording slow = read(sine_at(times_of_steps({60, 90, 140}, 500)));
  CHECK(warning(slow.warnings, "uneven_times")->severity == Severity::caution);
  // Pairs of samples 0.1 ms apart that differ by noise of 0.001: a cubic through them would be off by 0.1.
  std::vector<double> times = times_of_steps({9, 11}, 400);
  for (std::size_t k = 100; k < 400; k += 10) times[k] = times[k - 1] + 1e-4;
  std::string text = "time,sway_deg\n";
  char line[64];
  for (std::size_t k = 0; k < times.size(); ++k) {
    std::snprintf(line, sizeof line, "%.6f,%.4f\n", times[k], k % 2 == 0 ? 1.001 : 1.0);
    text += line;
  }
  const Recording close = read(text);
  for (const double value : close.signals.at(com_sway).rad) CHECK(within(value / sim::rad_per_deg, 1.0, 2e-3));
}

TEST_CASE("times rounded so that samples share them are an even grid from any start") {
  for (const auto& [rate, decimals] : {std::pair{1000, 2}, {1000, 1}, {250, 2}, {256, 1}, {100, 0}, {60, 0}})
    for (const double begin_s : {0.0, 12.34567}) {
      const std::string times_of = std::to_string(rate) + " Hz, decimals: " + std::to_string(decimals);
      CAPTURE(times_of);
      CAPTURE(begin_s);
      std::vector<double> times;
      for (int k = 0; k < 121 * rate; ++k) times.push_back(begin_s + k / static_cast<double>(rate));
      const Recording recording = read(sine_at(times, ("%." + std::to_string(decimals) + "f,%.9f\n").c_str()));
      CHECK(recording.rate_hz == static_cast<double>(rate));
      CHECK(warning(recording.warnings, "uneven_times")->severity == Severity::caution);
    }
  // Clock times to the second, which drop what is behind it.
  std::string text = "time,sway_deg\n";
  for (int k = 0; k < 12'100; ++k) {
    const int second = (k + 42) / 100;
    char line[64];
    std::snprintf(line, sizeof line, "12:%02d:%02d,%d\n", 3 + second / 60, second % 60, k % 7);
    text += line;
  }
  CHECK(read(text).rate_hz == 100.0);
  // A rate that is not a whole number stays one; lost samples are no rounding.
  std::vector<double> times;
  for (int k = 0; k < 20'000; ++k) times.push_back(0.37 + k / 148.148);
  CHECK(near(read(sine_at(times, "%.2f,%.9f\n")).rate_hz, 148.148, 1e-4));
  times.clear();
  for (int k = 0; k < 20'000; ++k)
    if (k < 9'000 || k >= 9'040) times.push_back(k / 1000.0);
  check_error([&] { read(sine_at(times, "%.2f,%.9f\n")); }, Code::times_uneven);
}

TEST_CASE("a given rate that the times have in another unit is an info; another rate is a caution") {
  for (const auto& [factor, severity] :
       {std::pair(1e3, Severity::info), {1e6, Severity::info}, {1e9, Severity::info}, {1e2, Severity::caution}}) {
    CAPTURE(factor);
    std::string text = "time,sway_deg\n";
    for (int k = 0; k < 100; ++k)
      text += format("%.0f,%.6f\n", 0.01 * factor * k, std::sin(0.1 * static_cast<double>(k)));
    const Recording recording = read(text, {.rate_hz = 100.0});
    CHECK(recording.rate_hz == 100.0);
    const auto found = std::ranges::find(recording.warnings, "rate_differs", &Warning::code);
    REQUIRE(found != recording.warnings.end());
    CHECK(found->severity == severity);
  }
}
