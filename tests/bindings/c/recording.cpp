// Recordings through C: each option of files and samples reaches the library, whose tests (tests/recording) say what it
// does.
#include "recording/recording.hpp"

#include <cmath>
#include <cstring>

#include "base/text.hpp"
#include "recording/signals.hpp"
#include "tests/bindings/c/owned.hpp"

namespace decid {
namespace {

using namespace test;
using recording::RecordingOptions;
using recording::Unit;

constexpr int count = 300;
/// Columns of the files below. `gappy` has one value of -77.5, `offset` a mean of 25.
constexpr const char* header = "time,sway,tilt,leg_deg,trunk_deg,hip,shoulder,ankle,gappy,offset\n";

std::string row(int k) {
  const auto wave = [k](double rate) { return std::sin(rate * k) + 0.1 * std::sin(0.9 * k); };
  return format("%.2f,%.17g,%.17g,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f\n", k / 100.0, wave(0.1), wave(0.2), wave(0.3),
                wave(0.4), wave(0.5), wave(0.6), wave(0.7), k == 30 ? -77.5 : wave(0.8), 25.0 + wave(0.15));
}

std::string rows(int first, int end, const std::string& before = "") {
  std::string text;
  for (int k = first; k < end; ++k) text += before + row(k);
  return text;
}

/// The recording is the library's.
void check_same(const decid_recording* found, const recording::Recording& expected) {
  const auto check_signal = [&](const double* values, std::string_view name) {
    const auto* signal = expected.signals.find(name);
    REQUIRE((values != nullptr) == (signal != nullptr));
    if (signal == nullptr) return;
    REQUIRE(decid_recording_samples(found) == signal->rad.size());
    CHECK(std::memcmp(values, signal->rad.data(), signal->rad.size() * sizeof *values) == 0);
  };
  check_signal(decid_recording_sway(found), recording::com_sway);
  check_signal(decid_recording_tilt(found), recording::platform_tilt);
  CHECK(decid_recording_rate_hz(found) == expected.rate_hz);
  if (!expected.file.empty()) CHECK(decid_recording_column(found) == expected.signals.at(recording::com_sway).column);
  REQUIRE(decid_recording_warnings(found) == expected.warnings.size());
  for (std::size_t i = 0; i < expected.warnings.size(); ++i)
    CHECK(decid_recording_warning(found, i)->code == expected.warnings[i].code);
}

}  // namespace

TEST_CASE("C: every option of reading a file reaches the library") {
  const TemporaryFolder folder;
  write_text(folder / "table.csv", std::string("Laboratory 3\n") + header + rows(0, count));
  write_text(folder / "sections.csv",
             std::string("Devices\n") + header + rows(0, 60) + "\nTrajectories\n" + header + rows(60, 150));
  write_text(folder / "long.csv",
             std::string("subject,") + header + rows(0, 50, "a,") + rows(0, 80, "b,") + rows(0, 60, "c,"));
  write_text(folder / "blocks.csv", std::string("block,") + header + rows(0, 50, "1,") + rows(50, count, "2,"));
  decid_read_options options;
  decid_read_defaults(&options, sizeof options);
  const auto check = [&](const char* file, const RecordingOptions& same) {
    const auto path = folder / file;
    check_same(make<OwnedRecording>([&](decid_recording** place) {
                 return decid_recording_read(path.c_str(), &options, place);
               }).get(),
               recording::read_recording(path, same));
    decid_read_defaults(&options, sizeof options);
  };
  options.column = "leg_deg";
  check("table.csv", {.column = "leg_deg"});
  options.unit = DECID_DEGREES;
  check("table.csv", {.unit = Unit::degree});
  options.unit = DECID_RADIANS;
  check("table.csv", {.unit = Unit::radian});
  options.unit = DECID_MILLIRADIANS;
  check("table.csv", {.unit = Unit::milliradian});
  options.rate_hz = 50.0;
  check("table.csv", {.rate_hz = 50.0});
  const double missing = -77.5;
  options.column = "gappy";
  options.fill_gaps_s = 0.1;
  options.missing_value = &missing;
  check("table.csv", {.column = "gappy", .missing_value = missing, .fill_gaps_s = 0.1});
  options.tilt_column = "hip";
  check("table.csv", {.tilt_column = "hip"});
  options.tilt_column = "none";
  check("table.csv", {.find_tilt = false});
  options.tilt_unit = DECID_MILLIRADIANS;
  check("table.csv", {.tilt_unit = Unit::milliradian});
  options.invert_sway = 1;
  check("table.csv", {.invert_sway = true});
  options.invert_tilt = 1;
  check("table.csv", {.invert_tilt = true});
  options.column = "2";
  options.skip_lines = 5;  // the name, the header and three rows
  check("table.csv", {.column = "2", .skip_lines = 5});
  options.leg_column = "leg_deg";
  options.trunk_column = "trunk_deg";
  check("table.csv", {.leg_column = "leg_deg", .trunk_column = "trunk_deg"});
  for (const auto& [unit, metres] :
       {std::pair(DECID_MILLIMETRES, 1e-3), {DECID_CENTIMETRES, 1e-2}, {DECID_METRES, 1.0}}) {
    options.column = "hip";
    options.com_height_m = 3.0;
    options.unit = unit;
    check("table.csv", {.column = "hip", .com_height_m = 3.0, .metres_per_unit = metres});
  }
  options.unit = DECID_CENTIMETRES;
  options.hip_column = "hip";
  options.shoulder_column = "shoulder";
  options.ankle_column = "ankle";
  options.body_height_m = 1.7;
  check("table.csv", {.hip_column = "hip",
                      .shoulder_column = "shoulder",
                      .ankle_column = "ankle",
                      .body_height_m = 1.7,
                      .metres_per_unit = 1e-2});
  for (const bool upright : {false, true}) {
    options.column = "offset";
    options.unit = DECID_DEGREES;
    options.mean_is_upright = upright ? 1 : 0;
    check("table.csv", {.column = "offset", .unit = Unit::degree, .mean_is_upright = upright});
  }
  options.section = "Trajectories";
  check("sections.csv", {.section = "Trajectories"});
  options.trial_column = "subject";
  options.trial = "b";
  check("long.csv", {.trial_column = "subject", .trial = "b"});
  options.trial_column = "none";
  check("blocks.csv", {.is_one_trial = true});

  options.trial_column = "subject";
  const auto trials = make<std::unique_ptr<decid_trials, Freed<decid_trials_free>>>(
      [&](decid_trials** place) { return decid_trials_read((folder / "long.csv").c_str(), &options, place); });
  REQUIRE(decid_trials_count(trials.get()) == 3);
  CHECK(std::string(decid_trials_name(trials.get(), 1)) == "b");
  CHECK(decid_trials_name(trials.get(), 3) == nullptr);
}

TEST_CASE("C: every option of samples does what a file's does") {
  const TemporaryFolder folder;
  std::vector<double> values[3];  // sway, tilt and the sway with an offset
  std::string text = "time,sway,tilt,offset\n";
  for (int k = 0; k < count; ++k) {
    const double sample[] = {std::sin(0.1 * k), std::sin(0.2 * k), 25.0 + std::sin(0.15 * k)};
    for (int of = 0; of < 3; ++of) values[of].push_back(sample[of]);
    text += format("%.2f,%.17g,%.17g,%.17g\n", k / 100.0, sample[0], sample[1], sample[2]);
  }
  const auto path = write_text(folder / "samples.csv", text);
  const auto check = [&](bool has_offset, decid_samples_options asked, RecordingOptions same) {
    asked.size = sizeof asked;
    asked.unit = DECID_DEGREES;
    same.unit = Unit::degree;
    same.column = has_offset ? "offset" : "sway";
    same.find_tilt = asked.tilt != nullptr;
    if (same.find_tilt) same.tilt_column = "tilt";
    if (same.find_tilt && !same.tilt_unit) same.tilt_unit = Unit::degree;
    recording::Recording expected = recording::read_recording(path, same);
    expected.file.clear();
    const std::vector<double>& sway = values[has_offset ? 2 : 0];
    check_same(make<OwnedRecording>([&](decid_recording** place) {
                 return decid_recording_of_samples(sway.data(), sway.size(), 100.0, &asked, place);
               }).get(),
               expected);
  };
  decid_samples_options asked{};
  for (const bool upright : {false, true}) {
    asked.mean_is_upright = upright ? 1 : 0;
    check(true, asked, {.mean_is_upright = upright});
  }
  asked = {};
  asked.tilt = values[1].data();
  check(false, asked, {});
  asked.tilt_unit = DECID_MILLIRADIANS;
  check(false, asked, {.tilt_unit = Unit::milliradian});
  asked.invert_sway = 1;
  check(false, asked, {.tilt_unit = Unit::milliradian, .invert_sway = true});
  asked.invert_tilt = 1;
  check(false, asked, {.tilt_unit = Unit::milliradian, .invert_sway = true, .invert_tilt = true});
}

}  // namespace decid
