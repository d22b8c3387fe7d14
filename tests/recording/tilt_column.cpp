// The platform's tilt among columns without its name, and sways that are not taken for it.
#include "recording/detail/tilt/tilt_column.hpp"

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "base/math/random.hpp"
#include "recording/detail/tilt/tilt_start.hpp"
#include "recording/trial.hpp"
#include "sim/simulate.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"
#include "tests/recording/table/reading.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

const sim::Simulator& simulator() {
  static const sim::Simulator made(sim::default_protocol());
  return made;
}
const ProtocolPlan& plan() {
  static const ProtocolPlan made(simulator().protocol());
  return made;
}
const std::vector<double>& tilt() {
  static const std::vector<double> made = prescribed_tilt(simulator().protocol());
  return made;
}

/// Returns trial i of a body of the prior, with its vestibular noise or without.
std::vector<double> sway(std::uint64_t i, bool has_noise) {
  const sim::Protocol& protocol = simulator().protocol();
  const sim::ParameterTable& table = protocol.parameters();
  std::vector<double> values(static_cast<std::size_t>(simulator().samples()));
  for (std::uint64_t attempt = 0;; ++attempt) {
    const Random random(5, sim::streams::base_parameters, 1000 * i + attempt);
    sim::Parameters parameters(table.size());
    for (std::size_t p = 0; p < table.size(); ++p) parameters[p] = random.uniform(p, table[p].low, table[p].high);
    if (!has_noise) parameters = protocol.family().without_noise(parameters);
    if (simulator().run(parameters, Random(5, sim::streams::vestibular_noise, 1000 * i + attempt), values).valid)
      return values;
  }
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
Brought brought(const std::vector<Column>& columns, const RecordingOptions& options = {}) {
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
  made.trial = bring_to_protocol(made.recording, plan());
  return made;
}

std::string tilt_of(const Brought& made) {
  const Signal<float>* found = made.trial.signals.find(platform_tilt);
  return found == nullptr ? std::string() : found->column;
}

}  // namespace

TEST_CASE("a tilt without a tilt's name is found, with its size and start") {
  for (const char* name :
       {"tilt_cmd", "Platform Rx (deg)", "FS", "prts_deg", "Kippung (Grad)", "treadmill_pitch_deg"}) {
    CAPTURE(std::string(name));
    const Brought made = brought({{name, measured(tilt(), 2.0, 0.02, 50)}, {"other", measured(tilt(), 0.0, 0.0, 50)}});
    CHECK(tilt_of(made) == name);
    REQUIRE(made.trial.tilt);
    CHECK(within(made.trial.tilt->delay_s, 0.5, 0.02));
    CHECK(has(made.recording.warnings, "tilt_of_other_size"));
    CHECK(has(made.recording.warnings, "tilt_found"));
  }
  CHECK(tilt_of(brought({{"stim", measured(tilt(), 2.0)}}, {.find_tilt = false})).empty());
}

TEST_CASE("of several tilts the measured one is used, and a note names the others") {
  const std::vector<double> commanded = measured(tilt(), 1.0), played = measured(tilt(), 1.5, 0.02);
  for (const auto& names : {std::pair{"tilt_command_deg", "tilt_measured_deg"}, {"servo_target", "servo_angle"}}) {
    CHECK(tilt_of(brought({{names.first, commanded}, {names.second, played}})) == names.second);
    CHECK(tilt_of(brought({{names.second, played}, {names.first, commanded}})) == names.second);
  }
  const Brought first = brought({{"motor_angle", played}, {"table_angle", commanded}});
  CHECK(tilt_of(first) == "motor_angle");
  CHECK(warns(first.recording, "'table_angle'"));
  // The same for names of tilts.
  const Brought named = brought({{"tilt_deg", commanded}, {"platform_deg", played}});
  CHECK(tilt_of(named) == "tilt_deg");
  CHECK(warns(named.recording, "'platform_deg'"));
}

TEST_CASE("a tilt of the other sign, or with a name of the body, is only named, in a caution") {
  for (const auto& [name, factor] : {std::pair{"motor_angle", -1.0}, {"leg_deg", 1.0}}) {
    const Brought made = brought({{name, measured(tilt(), factor)}});
    CHECK(tilt_of(made).empty());
    CHECK(has(made.recording.warnings, "tilt_not_used"));
    CHECK(worst_trust(made.recording.warnings) == Trust::caution);
  }
  CHECK_FALSE(has(brought({{"ankle_deg", measured(tilt(), 1.0)}}).recording.warnings, "tilt_not_used"));
}

TEST_CASE("sways are not taken for the tilt: 2 of 400 noise-free ones may, 1 of 400 with vestibular noise") {
  // The correlation with the tilt at some start is above 0.9 for 97% of the noise-free sways, and for 19% of the
  // others.
  for (const bool has_noise : {false, true}) {
    CAPTURE(has_noise);
    int found = 0;
    for (std::uint64_t i = 0; i < 400; ++i) {
      Recording recording = make_recording(sway(i, has_noise), 100.0);
      recording.other_columns = {{platform_tilt, "trunk", recording.signals.at(com_sway).rad}};
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
  for (const std::size_t end : {501UL, 800UL, 5000UL}) {
    CAPTURE(end);
    const Brought twice = brought(with_gap(2.0, 500, end));
    REQUIRE(twice.trial.tilt);
    CHECK(has(twice.recording.warnings, "tilt_of_other_size"));
    CHECK_FALSE(has(twice.recording.warnings, "tilt_follows_roughly"));
    CHECK_FALSE(has(twice.recording.warnings, "time_slips"));
    CHECK(within(twice.trial.tilt->delay_s, 0.3, 0.01));
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
