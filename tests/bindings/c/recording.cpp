// Recordings through C: each option of samples reaches the library, whose tests (tests/recording) say what it does.
// test_package.py and test_functions.m compare the options of files with the program's.
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
  // Options of a file that other languages' tests do not give alone.
  for (const bool tilt : {false, true}) {
    decid_read_options reading;
    decid_read_defaults(&reading, sizeof reading);
    reading.column = "sway";
    (tilt ? reading.invert_tilt : reading.invert_sway) = 1;
    check_same(make<OwnedRecording>([&](decid_recording** place) {
                 return decid_recording_read(path.c_str(), &reading, place);
               }).get(),
               recording::read_recording(path, {.column = "sway", .invert_sway = !tilt, .invert_tilt = tilt}));
  }
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
