// The platform's tilt among columns without its name, and sways that are not taken for it.
#include "recording/detail/tilt/tilt_column.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "base/math/random.hpp"
#include "recording/resample.hpp"
#include "recording/table/columns.hpp"
#include "recording/trial.hpp"
#include "sim/simulate.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"
#include "tests/recording/default_protocol.hpp"
#include "tests/recording/table/reading.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

const std::vector<double>& tilt() {
  return plan().tilt_rad();
}

/// Returns trial i of a body of the prior, with its vestibular noise or without.
std::vector<double> sway(std::uint64_t i, bool has_noise) {
  return trial_of_prior(5, i, [&](sim::Parameters& parameters) {
    if (!has_noise) parameters = simulator().protocol().family().without_noise(parameters);
  });
}

/// Returns values times a factor with noise of sd degrees, late by some samples.
std::vector<double> measured(const std::vector<double>& values, double factor, double sd_deg = 0.0,
                             std::size_t late = 0) {
  const Random random(6, sim::streams::sensor_noise, 0);
  std::vector<double> result;
  for (std::size_t k = 0; k < values.size() + late; ++k)
    result.push_back(factor * values[k < late ? 0 : k - late] + sd_deg * sim::rad_per_deg * random.normal(k));
  return result;
}

struct Column {
  std::string name;
  std::vector<double> rad;
};

/// A recording of body 1 and these columns, in degrees, brought to the protocol.
struct Brought {
  Recording recording;
  Trial trial;
};
Brought brought(const std::vector<Column>& columns, const RecordingOptions& options = {},
                const TrialOptions& how = {}) {
  const std::vector<double> body = measured(sway(1, true), 1.0, 0.02, columns.front().rad.size() - tilt().size());
  std::string text = "time,com_sway_deg";
  for (const Column& column : columns) text += "," + column.name;
  char cell[64];
  for (std::size_t k = 0; k < body.size(); ++k) {
    std::snprintf(cell, sizeof cell, "\n%.2f,%.5f", static_cast<double>(k) / 100.0, body[k] / sim::rad_per_deg);
    text += cell;
    for (const Column& column : columns) {
      if (std::isnan(column.rad[k]))
        text += ",";
      else
        text += (std::snprintf(cell, sizeof cell, ",%.5f", column.rad[k] / sim::rad_per_deg), cell);
    }
  }
  Brought made{read(text + "\n", options), {}};
  made.trial = bring_to_protocol(made.recording, plan(), how);
  return made;
}

std::string tilt_of(const Brought& made) {
  const Signal<float>* found = made.trial.signals.find(platform_tilt);
  return found == nullptr ? std::string() : found->column;
}

}  // namespace

TEST_CASE("a tilt without a tilt's name is found, with its start, and with its size if it has a unit") {
  for (const char* name :
       {"tilt_cmd", "Platform Rx (deg)", "FS", "prts_deg", "Kippung (Grad)", "treadmill_pitch_deg", "servo_target"}) {
    CAPTURE(std::string(name));
    const Brought made = brought({{name, measured(tilt(), 2.0, 0.02, 50)}, {"other", measured(tilt(), 0.0, 0.0, 50)}});
    CHECK(tilt_of(made) == name);
    REQUIRE(made.trial.tilt);
    CHECK(within(made.trial.tilt->delay_s, 0.5, 0.02));
    CHECK(has(made.recording.warnings, "tilt_found"));
    const bool has_unit = unit_in(name).has_value();
    CHECK(has(made.recording.warnings, "tilt_of_other_size") == has_unit);
    CHECK(made.trial.tilt->is_other_size == has_unit);
    CHECK(std::isnan(made.trial.tilt->gain) == !has_unit);
    if (has_unit) CHECK(within(made.trial.tilt->gain, 2.0, 0.01));
    CHECK(std::ranges::count(made.recording.warnings, "tilt_found", &Warning::code) == 1);
  }
  CHECK(tilt_of(brought({{"stim", measured(tilt(), 2.0)}}, {.find_tilt = false})).empty());
}

TEST_CASE("a command in volts or counts gives the start only") {
  const auto scaled = [](double factor, double offset_deg) {
    std::vector<double> values = measured(tilt(), factor, 0.01 * factor, 50);
    for (double& value : values) value += offset_deg * sim::rad_per_deg;
    return values;
  };
  for (const auto& [name, values] : {std::pair{"actuator", scaled(5.0, 2.5)},
                                     {"command", scaled(0.2, 0.0)},
                                     {"dac", scaled(100.0, 2048.0)},
                                     {"ao0", scaled(0.01, 0.0)}}) {
    const std::string column = name;
    CAPTURE(column);
    const Brought made = brought({{column, values}});
    REQUIRE(made.trial.tilt);
    CHECK(within(made.trial.tilt->delay_s, 0.5, 0.005));
    CHECK_FALSE(made.trial.tilt->is_other_size);
    for (const Warning& warning : made.recording.warnings)
      if (warning.code.starts_with("tilt_")) CHECK(warning.severity == Severity::info);
    CHECK(within(made.trial.signals.at(platform_tilt).rad[3000], tilt()[3000], 0.1 * sim::rad_per_deg));
  }
  // At a start that was given, 0.3 s early, its size says nothing either.
  const Brought given = brought({{"dac", scaled(100.0, 2048.0)}}, {}, {.start_s = 0.3});
  CHECK(given.trial.tilt_at_given_start.has_value());
  CHECK_FALSE(has(given.recording.warnings, "tilt_of_other_size"));
}

TEST_CASE("of several tilts the one of the protocol's size is used, then the measured one; a note names the others") {
  const std::vector<double> commanded = measured(tilt(), 1.0), played = measured(tilt(), 1.05, 0.02);
  for (const auto& names : {std::pair{"tilt_command_deg", "tilt_measured_deg"}, {"servo_target", "servo_angle"}}) {
    CHECK(tilt_of(brought({{names.first, commanded}, {names.second, played}})) == names.second);
    CHECK(tilt_of(brought({{names.second, played}, {names.first, commanded}})) == names.second);
    // 1.5 times the size: its unit may be another; with a unit a caution says so.
    const Brought larger = brought({{names.second, measured(tilt(), 1.5, 0.02)}, {names.first, commanded}});
    CHECK(tilt_of(larger) == names.first);
    CHECK_FALSE(larger.trial.tilt->is_other_size);
    CHECK(has(larger.recording.warnings, "tilt_of_other_size") == unit_in(names.second).has_value());
  }
  const Brought first = brought({{"motor_angle", played}, {"table_angle", commanded}});
  CHECK(tilt_of(first) == "motor_angle");
  CHECK(warns(first.recording, "'table_angle'"));
  // The same for names of tilts.
  const Brought named = brought({{"tilt_deg", commanded}, {"platform_deg", played}});
  CHECK(tilt_of(named) == "tilt_deg");
  CHECK(warns(named.recording, "'platform_deg'"));
}

TEST_CASE(
    "a tilt of the other sign, or with a name of the body, is only named: in a caution, or in a note if it is a "
    "command or has no unit") {
  const auto trust = [&](const char* name, double factor) {
    const Brought made = brought({{name, measured(tilt(), factor)}});
    CHECK(tilt_of(made).empty());
    CHECK(has(made.recording.warnings, "tilt_not_used"));
    return worst_trust(made.recording.warnings);
  };
  CHECK(trust("motor_angle_deg", -1.0) == Trust::caution);
  CHECK(trust("leg_deg", 1.0) == Trust::caution);
  CHECK(trust("motor", -1.0) == Trust::usable);
  CHECK(trust("leg", 1.0) == Trust::usable);
  CHECK(trust("motor_command_deg", -1.0) == Trust::usable);
  for (const char* name : {"sway_stimulus", "body_platform_deg", "leg_motor_deg"})
    CHECK(tilt_of(brought({{name, measured(tilt(), 1.0)}})) == name);
  CHECK_FALSE(has(brought({{"ankle_deg", measured(tilt(), 1.0)}}).recording.warnings, "tilt_not_used"));
}

TEST_CASE("a column is compared closely only if it follows the tilt at 10 Hz, or has no such values") {
  const std::vector<double> played = measured(tilt(), 1.0, 0.02, 30);
  const Random random(6, sim::streams::sensor_noise, 1);
  std::vector<double> walk(played.size(), 0.0);
  for (std::size_t k = 1; k < walk.size(); ++k) walk[k] = 0.999 * walk[k - 1] + 1e-3 * random.normal(k);
  for (const double rate_hz : {100.0, 60.0, 148.0, 1000.0}) {
    CAPTURE(rate_hz);
    Recording recording = make_recording(resample(played, 100.0, rate_hz), rate_hz);
    int read = 0;
    const auto column = [&](const char* name, const std::vector<double>& at_100_hz, bool is_screened) {
      const std::vector<double> rad = resample(at_100_hz, 100.0, rate_hz);
      OtherColumn made{name, true, [&read, rad] { return ++read, rad; }};
      if (is_screened) {
        made.coarse_step = static_cast<std::size_t>(std::lround(rate_hz / 10.0));
        for (std::size_t k = 0; k < rad.size(); k += made.coarse_step) made.coarse_rad.push_back(rad[k]);
      }
      return made;
    };
    recording.other_columns = {column("walk", walk, true), column("b", played, true), column("c", walk, false)};
    look_for_tilt_by_values(plan(), rate_hz, recording);
    CHECK(read == 2);
    REQUIRE(recording.signals.find(platform_tilt) != nullptr);
    CHECK(recording.signals.at(platform_tilt).column == "b");
  }
}

TEST_CASE("sways are not taken for the tilt: 2 of 400 noise-free ones may, 1 of 400 with vestibular noise") {
  // The correlation with the tilt at some start is above 0.9 for 97% of the noise-free sways, and for 19% of the
  // others.
  for (const bool has_noise : {false, true}) {
    CAPTURE(has_noise);
    int found = 0;
    for (std::uint64_t i = 0; i < 400; ++i) {
      Recording recording = make_recording(sway(i, has_noise), 100.0);
      const std::vector<double> rad = recording.signals.at(com_sway).rad;
      recording.other_columns = {{"trunk", true, [rad] { return rad; }}};
      look_for_tilt_by_values(plan(), 100.0, recording);
      found += recording.warnings.empty() ? 0 : 1;
    }
    CHECK(found <= (has_noise ? 1 : 2));
  }
}

TEST_CASE("a tilt with missing values is compared where it was measured") {
  const double nan = std::nan("");
  const auto with_gap = [&](double factor, std::size_t first, std::size_t end) {
    std::vector<double> values = measured(tilt(), factor, 0.02, 30);
    for (std::size_t k = first; k < end; ++k) values[k] = nan;
    return std::vector<Column>{{"tilt_deg", values}};
  };
  for (const std::size_t end : {501UL, 5000UL}) {
    CAPTURE(end);
    const Brought twice = brought(with_gap(2.0, 500, end));
    REQUIRE(twice.trial.tilt);
    CHECK(has(twice.recording.warnings, "tilt_of_other_size"));
    CHECK_FALSE(has(twice.recording.warnings, "tilt_follows_roughly"));
    CHECK_FALSE(has(twice.recording.warnings, "time_slips"));
    CHECK(within(twice.trial.tilt->delay_s, 0.3, 0.002));
    CHECK(within(twice.trial.tilt->gain, 2.0, 0.01));
    // Filled as prescribed: a frequency response needs the tilt.
    CHECK(within(twice.trial.signals.at(platform_tilt).rad[(500 + end) / 2 - 30], 2.0 * tilt()[(500 + end) / 2 - 30],
                 0.02 * sim::rad_per_deg));
    CHECK(worst_trust(brought(with_gap(-1.0, 500, end)).recording.warnings) == Trust::not_usable);
    CHECK(brought(with_gap(1.0, 500, end), {.tilt_column = "tilt_deg"}).trial.tilt.has_value());
  }
  const Brought half = brought(with_gap(1.0, 2000, 9000));
  CHECK(tilt_of(half).empty());
  REQUIRE(has(half.recording.warnings, "tilt_not_used"));
  CHECK(worst_trust(half.recording.warnings) == Trust::caution);
}

TEST_CASE("the start of a tilt with gaps is without bias, and nothing is lacking there") {
  const auto with_gaps = [&](std::size_t late, std::size_t first, std::size_t length, std::size_t period) {
    std::vector<double> values = measured(tilt(), 1.0, 0.01, late);
    for (std::size_t begin = first; begin < values.size(); begin += period)
      for (std::size_t k = begin; k < std::min(begin + length, values.size()); ++k) values[k] = std::nan("");
    return brought({{"tilt_deg", values}});
  };
  constexpr std::size_t once = 100000;
  for (const std::size_t late : {0UL, 57UL})
    for (const auto& gaps : {std::array{3000UL, 4840UL, once},
                             {100UL, 4840UL, once},
                             {4000UL, 5800UL, once},
                             {6200UL, 5800UL, once},
                             {100UL, 200UL, 500UL}}) {
      CAPTURE(late);
      CAPTURE(gaps[0]);
      CAPTURE(gaps[1]);
      const Brought made = with_gaps(late, gaps[0], gaps[1], gaps[2]);
      REQUIRE(made.trial.tilt);
      CHECK(within(made.trial.tilt->delay_s, static_cast<double>(late) / 100.0, 0.002));
      CHECK(within(made.trial.tilt->gain, 1.0, 0.01));
      CHECK_FALSE(has(made.recording.warnings, "samples_lacking"));
    }
}

TEST_CASE("a tilt of fewer samples than the sway is interpolated") {
  const auto every = [&](std::size_t step, double factor) {
    std::vector<double> values = measured(tilt(), factor, 0.02, 30);
    for (std::size_t k = 0; k < values.size(); ++k)
      if (k % step != 0) values[k] = std::nan("");
    return values;
  };
  const Brought sparse = brought({{"tilt_deg", every(10, 1.0)}});
  REQUIRE(sparse.trial.tilt);
  CHECK(within(sparse.trial.tilt->delay_s, 0.3, 0.005));
  CHECK(within(sparse.trial.tilt->gain, 1.0, 0.02));
  for (const char* code : {"tilt_not_used", "tilt_follows_roughly", "time_slips", "clock_differs"})
    CHECK_FALSE(has(sparse.recording.warnings, code));
  CHECK(has(brought({{"tilt_deg", every(10, 2.0)}}).recording.warnings, "tilt_of_other_size"));
  // One sample per second is no tilt.
  CHECK(has(brought({{"tilt_deg", every(100, 1.0)}}).recording.warnings, "tilt_not_used"));
}

TEST_CASE("two columns of one tilt's name: the first if they are equal, else the one that moves as the protocol") {
  const std::vector<double> played = measured(tilt(), 1.0, 0.02, 30);
  const auto found = [](const std::vector<double>& a, const std::vector<double>& b) {
    return brought({{"tilt_deg", a}, {"tilt_deg", b}});
  };
  std::vector<double> other = measured(tilt(), 0.0, 1.0, 30), gap = played;
  gap[700] = std::nan("");
  for (const Brought& made : {found(played, played), found(gap, gap), found(played, other), found(other, played)}) {
    REQUIRE(made.trial.tilt);
    CHECK(within(made.trial.tilt->delay_s, 0.3, 0.002));
    CHECK_FALSE(has(made.recording.warnings, "tilt_not_used"));
    CHECK(has(made.recording.warnings, "tilt_found"));
  }
  const Brought neither = found(other, measured(tilt(), 0.0, 0.5, 30));
  CHECK(tilt_of(neither).empty());
  REQUIRE(has(neither.recording.warnings, "tilt_not_used"));
  CHECK(worst_trust(neither.recording.warnings) == Trust::caution);
}

TEST_CASE("numbers for missing values of the tilt are named, and a constant tilt stands still") {
  std::vector<double> values = measured(tilt(), 1.0);
  for (std::size_t k = 100; k < 12000; k += 230) values[k] = -999.0 * sim::rad_per_deg;
  const Brought coded = brought({{"tilt_deg", values}});
  CHECK(worst_trust(coded.recording.warnings) == Trust::caution);
  CHECK(warns(coded.recording, "missing -999"));
  CHECK(brought({{"tilt_deg", values}}, {.missing_value = -999.0}).trial.tilt.has_value());
  const Brought still = brought({{"tilt_deg", measured(tilt(), 0.0)}});
  CHECK(worst_trust(still.recording.warnings) == Trust::not_usable);
  CHECK(warns(still.recording, "stood still"));
  // A column of conditions is not a tilt.
  const Recording words = read("time,sway_deg,platform\n0,1,fixed\n0.01,2,tilted\n0.02,2,tilted\n");
  CHECK(worst_trust(words.warnings) == Trust::usable);
  CHECK(has(words.warnings, "tilt_not_used"));
}

TEST_CASE("two columns of the tilt by their names are not a sway") {
  check_error(reading("time,tilt_deg,platform_deg\n0,1,0\n0.01,2,0.1\n"), Code::column_missing, "platform_deg");
  CHECK(read("time,tilt_deg,platform_deg,lean\n0,1,0,1\n0.01,2,0.1,2\n").signals.at(com_sway).column == "lean");
}
