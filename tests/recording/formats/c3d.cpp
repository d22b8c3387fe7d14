// C3D files: the numbers of each processor, what their parameters say, and what a file may claim.
#include "recording/formats/detail/c3d.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>
#include <tuple>

#include "recording/recording.hpp"
#include "sim/protocol/protocol.hpp"
#include "tests/helpers.hpp"
#include "tests/recording/formats/c3d_file.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

constexpr std::size_t frames = 60;

/// Positions in mm and angles in degrees that every format writes without rounding.
double in_steps(std::size_t frame, int amplitude, int period) {
  const double part = static_cast<double>(frame) / period;
  return std::round(amplitude * std::sin(6.28 * part)) / 64.0;
}

std::vector<double> signal(int amplitude, int period, std::size_t count = frames) {
  std::vector<double> values;
  for (std::size_t k = 0; k < count; ++k) values.push_back(in_steps(k, amplitude, period));
  return values;
}

std::vector<double> still(std::size_t count = frames) {
  return std::vector<double>(count, 12.5);
}

/// Hip, shoulder, ankle and a tilt in 128ths of a degree.
C3dFile trial(unsigned processor, bool real) {
  C3dFile file(processor, real);
  file.point("HIP", signal(900, 40), still(), still());
  file.point("C7", signal(1500, 40), still(), still());
  file.point("ANK", signal(30, 25), still(), still());
  std::vector<double> raw;
  for (const double degrees : signal(128, 30)) raw.push_back(128.0 * degrees + 7.0);
  file.channel("platform", "deg", raw, 1.0 / 128.0, 7);
  return file;
}

const RecordingOptions markers{
    .hip_column = "HIP_x", .shoulder_column = "C7_x", .ankle_column = "ANK_x", .body_height_m = 1.7};

Recording read(const std::string& bytes, const RecordingOptions& options = {}) {
  const TemporaryFolder folder;
  return read_recording(write_text(folder / "r.c3d", bytes), options);
}

auto reading(const std::string& bytes, const RecordingOptions& options = markers) {
  return [bytes, options] { read(bytes, options); };
}

C3dTable table_for(const C3dFile& file) {
  return {file.bytes(), "r.c3d"};
}

void put(std::string& bytes, std::size_t at, const std::string& what) {
  bytes.replace(at, what.size(), what);
}

}  // namespace

TEST_CASE("a trial of every processor, in integers and reals, is the trial of its CSV") {
  std::string text = "time,HIP_x (mm),C7_x (mm),ANK_x (mm),platform (deg)\n";
  char row[160];
  for (std::size_t k = 0; k < frames; ++k) {
    std::snprintf(row, sizeof row, "%.2f,%.6f,%.6f,%.6f,%.7f\n", static_cast<double>(k) / 100.0, in_steps(k, 900, 40),
                  in_steps(k, 1500, 40), in_steps(k, 30, 25), in_steps(k, 128, 30));
    text += row;
  }
  const TemporaryFolder folder;
  const Recording csv = read_recording(write_text(folder / "r.csv", text), markers);
  for (const unsigned processor : {intel, dec, mips}) {
    for (const bool real : {false, true}) {
      CAPTURE(processor);
      CAPTURE(real);
      const Recording c3d = read(trial(processor, real).bytes(), markers);
      CHECK(c3d.rate_hz == csv.rate_hz);
      for (const char* name : {com_sway, platform_tilt}) {
        CHECK(c3d.signals.at(name).column == csv.signals.at(name).column);
        CHECK(c3d.signals.at(name).rad == csv.signals.at(name).rad);
      }
      CHECK(c3d.warnings == csv.warnings);
    }
  }
}

TEST_CASE("C3D: DEC's reals, largest, smallest and invalid ones") {
  const std::string where = "r.c3d";
  const auto real = [&](const std::string& bytes) { return C3dBytes(bytes, C3dBytes::Processor::dec, where).real(0); };
  CHECK(real(std::string("\x80\x40\x00\x00", 4)) == 1.0);
  CHECK(real(std::string("\x49\xC1\xDB\x0F", 4)) == -3.1415927410125732);
  CHECK(real(std::string("\xFF\x7F\xFF\xFF", 4)) == std::ldexp(1.0 - std::ldexp(1.0, -24), 127));
  CHECK(real(std::string("\x80\x00\x00\x00", 4)) == std::ldexp(1.0, -128));
  CHECK(real(std::string("\x00\x00\xFF\xFF", 4)) == 0.0);
  CHECK(std::isnan(real(std::string("\x00\x80\x00\x00", 4))));
}

TEST_CASE("C3D: a negative residual is a gap") {
  for (const bool real : {false, true}) {
    C3dFile file(intel, real);
    std::vector<double> residual(frames);
    residual[7] = residual[8] = -1.0;
    residual[20] = 3.0;
    file.first_frame = 101;
    file.point("COM", signal(900, 40), still(), still(), residual);
    RecordingOptions options{.column = "COM_x", .com_height_m = 0.9};
    check_error(reading(file.bytes(), options), Code::value_missing, "frame 108");
    options.fill_gaps_s = 0.02;
    const Recording filled = read(file.bytes(), options);
    CHECK(has(filled.warnings, "gaps_filled"));
    CHECK(filled.signals.samples() == frames);
    options.fill_gaps_s = 0.01;
    check_error(reading(file.bytes(), options), Code::value_missing, "fill_gaps");
  }
  C3dFile file;
  std::vector<double> x = signal(900, 40);
  x[3] = std::numeric_limits<double>::infinity();
  file.point("COM", x, still(), still());
  check_error(reading(file.bytes(), {.column = "COM_x", .fill_gaps_s = 1.0, .com_height_m = 0.9}), Code::value_invalid,
              "frame 4");
}

TEST_CASE("C3D: positions are lengths: as an angle they are refused, with a height they are sway") {
  C3dFile file;
  file.point("COM", signal(900, 40), still(), still());
  check_error(reading(file.bytes(), {}), Code::column_unsuitable, "COM_x");
  CHECK(read(file.bytes(), {.com_height_m = 0.9}).signals.at(com_sway).column == "COM_x (mm)");
  file.texts("POINT:UNITS", {"m"});
  CHECK(table_for(file).names()[0] == "COM_x (m)");
  file.parameters.erase("POINT:UNITS");
  CHECK(table_for(file).names()[0] == "COM_x");
  check_error(reading(file.bytes(), {.com_height_m = 0.9}), Code::unit_unknown, "COM_x");
  check_error(reading(trial(intel, true).bytes(), {}), Code::column_missing);
  file.point("C7", still(), still(), still());
  file.texts("POINT:LABELS", {"HIP", "C7"});
  file.texts("POINT:UNITS", {"mm"});
  check_error(reading(file.bytes(), {}), Code::column_ambiguous, "'HIP_x (mm)', 'HIP_y (mm)'");
}

TEST_CASE("C3D: names of points and channels, and their units") {
  using Names = std::vector<std::string>;
  C3dFile file;
  file.point("Ann:LASI", still(), still(), still());
  file.point("", still(), still(), still());
  file.point("Ann:Trunk", signal(64, 30), still(), still());
  file.channel("", "", still());
  file.channel("Fz\xB0", "N", still());
  file.texts("POINT:LABELS", {"Ann:LASI"});
  file.texts("POINT:LABELS2", {"", "Ann:Trunk"});
  file.texts("POINT:ANGLES", {"Ann:Trunk"});
  file.texts("POINT:ANGLE_UNITS", {"deg"});
  CHECK(table_for(file).names() == Names{"LASI_x (mm)", "LASI_y (mm)", "LASI_z (mm)", "point 2_x (mm)",
                                         "point 2_y (mm)", "point 2_z (mm)", "Trunk_x (deg)", "Trunk_y (deg)",
                                         "Trunk_z (deg)", "analog 1", "Fz\xC2\xB0 (N)"});
  const Recording angle = read(file.bytes(), {.column = "trunk_x"});
  CHECK(angle.signals.at(com_sway).rad[5] == in_steps(5, 64, 30) * sim::rad_per_deg);
  CHECK_FALSE(has(angle.warnings, "unit_assumed"));
  // Lists of kinds may leave out the subject's name, or be alone in having it.
  file.texts("POINT:ANGLES", {"Trunk"});
  CHECK(table_for(file).names()[6] == "Trunk_x (deg)");
  file.texts("POINT:ANGLES", {"Ann:Trunk"});
  file.texts("POINT:LABELS", {"LASI"});
  file.texts("POINT:LABELS2", {"", "Trunk"});
  CHECK(table_for(file).names()[6] == "Trunk_x (deg)");
  file.texts("POINT:LABELS", {"Ann:LASI"});
  // Two subjects keep their names.
  file.texts("POINT:LABELS2", {"", "Bob:Trunk"});
  CHECK(table_for(file).names()[0] == "Ann:LASI_x (mm)");
  CHECK(table_for(file).names()[8] == "Bob:Trunk_z (mm)");
  file.texts("POINT:ANGLES", {"Bob:Trunk"});
  CHECK(table_for(file).names()[8] == "Bob:Trunk_z (deg)");
}

TEST_CASE("C3D: a file of any name is one recording, without sections; no channel is its time or divides it") {
  C3dFile file;
  file.point("T", still(), still(), still());
  file.channel("time", "", still());
  file.channel("trial", "", signal(64, 7));
  file.channel("sway", "deg", signal(64, 30));
  const TemporaryFolder folder;
  const std::filesystem::path path = write_text(folder / "r.csv", file.bytes());
  const Recording recording = read_recording(path, {});
  CHECK(recording.rate_hz == 100.0);
  CHECK(recording.signals.at(com_sway).column == "sway (deg)");
  for (const char* column : {"trial", "none such", "1"}) {
    check_error([&] { read_recording(path, {.trial_column = column, .trial = "1"}); }, Code::setting_conflict,
                "trial_column");
    check_error([&] { list_trials(path, {.trial_column = column}); }, Code::setting_conflict, "trial_column");
  }
  check_error([&] { read_recording(path, {.skip_lines = 1}); }, Code::setting_conflict, "skip_lines");
  check_error([&] { read_recording(path, {.section = "1"}); }, Code::setting_conflict, "C3D file");
}

TEST_CASE("C3D: offset and scale of analog channels") {
  for (const bool real : {false, true}) {
    C3dFile file(mips, real);
    file.channel("a", "deg", {10.0, 11.0, 12.0}, 0.5, 2);
    file.channel("b", "deg", {-3.0, 0.0, 3.0}, 4.0, -1);
    file.reals("ANALOG:GEN_SCALE", {0.25});
    CHECK(table_for(file).numbers(0, Missing::refused) == std::vector{1.0, 1.125, 1.25});
    CHECK(table_for(file).numbers(1, Missing::refused) == std::vector{-2.0, 1.0, 4.0});
    file.parameters.erase("ANALOG:OFFSET");
    file.parameters.erase("ANALOG:SCALE");
    CHECK(table_for(file).numbers(1, Missing::refused) == std::vector{-0.75, 0.0, 0.75});
    file.reals("ANALOG:SCALE", {1.0});
    check_error([&] { table_for(file); }, Code::file_damaged, "1 values");
  }
  C3dFile file(intel, false);
  file.channel("a", "deg", {32768.0, 40001.0, 65535.0}, 1.0, 40000);
  file.texts("ANALOG:FORMAT", {"UNSIGNED"});
  CHECK(table_for(file).numbers(0, Missing::refused) == std::vector{-7232.0, 1.0, 25535.0});
}

TEST_CASE("C3D: channels faster than the points are brought to their rate, without delay") {
  constexpr std::size_t fast = 10;
  const auto wave = [](double s) { return 2.0 * std::sin(6.0 * s); };
  std::vector<double> raw;
  for (std::size_t k = 0; k < fast * frames; ++k) raw.push_back(wave(static_cast<double>(k) / 1000.0));
  C3dFile file(intel, true);
  file.channel("sway", "deg", raw, 1.0, 0, fast);
  // Alone, at their own rate.
  const Recording alone = read(file.bytes());
  CHECK(alone.rate_hz == 1000.0);
  CHECK(alone.signals.samples() == fast * frames);
  CHECK_FALSE(has(alone.warnings, "resampled"));
  file.point("COM", signal(900, 40), still(), still());
  const Recording beside = read(file.bytes(), {.column = "sway"});
  CHECK(beside.rate_hz == 100.0);
  CHECK(has(beside.warnings, "resampled"));
  REQUIRE(beside.signals.samples() == frames);
  for (std::size_t k = 15; k < frames - 15; ++k)  // the filter sees values that are held beyond the ends
    CHECK(within(beside.signals.at(com_sway).rad[k] / sim::rad_per_deg, wave(static_cast<double>(k) / 100.0), 0.01));
  // A gap would spread over what the filter sees.
  raw[25] = std::numeric_limits<double>::quiet_NaN();
  C3dFile gap(intel, true);
  gap.point("COM", signal(900, 40), still(), still());
  gap.channel("sway", "deg", raw, 1.0, 0, fast);
  check_error(reading(gap.bytes(), {.column = "sway", .fill_gaps_s = 1.0}), Code::value_missing, "frame 3");
}

TEST_CASE("C3D: the rate is that of POINT:RATE, else of the header; several and none are refused") {
  const auto rate = [](C3dFile file, std::optional<double> given = {}) {
    RecordingOptions options = markers;
    options.rate_hz = given;
    return read(file.bytes(), options);
  };
  C3dFile file = trial(intel, true);
  file.reals("POINT:RATE", {50.0});
  check_error([&] { rate(file); }, Code::rate_unknown, "'POINT:RATE'");
  const Recording given = rate(file, 100.0);
  CHECK(given.rate_hz == 100.0);
  CHECK(has(given.warnings, "rate_differs"));
  file.parameters.erase("ANALOG:RATE");
  CHECK(rate(file).rate_hz == 50.0);
  file.parameters.erase("POINT:RATE");
  CHECK(rate(file).rate_hz == 100.0);
  for (const double none : {0.0, -50.0, 1e9, std::numeric_limits<double>::quiet_NaN()}) {
    C3dFile other(mips, true, none);
    other.point("COM", signal(900, 40), still(), still());
    const RecordingOptions options{.column = "COM_x", .com_height_m = 0.9};
    check_error(reading(other.bytes(), options), Code::setting_out_of_range, "r.c3d");
  }
}

TEST_CASE("C3D: more frames than 16 bits count") {
  constexpr std::size_t many = 70'000;
  C3dFile file(intel, false);
  file.point("COM", signal(900, 40, many), still(many), still(many));
  const auto rows = [](const C3dFile& made) { return table_for(made).rows(0); };
  CHECK(rows(file) == many);  // no parameter says more than 65,535
  CHECK(table_for(file).warnings().empty());
  C3dFile both = file;
  both.reals("POINT:LONG_FRAMES", {70'000.0});
  CHECK(rows(both) == many);
  both.integers("TRIAL:ACTUAL_START_FIELD", {11, 0});
  both.integers("TRIAL:ACTUAL_END_FIELD", {70'010 - 65'536, 1});
  CHECK(rows(both) == many);
  CHECK(table_for(both).locate(0) == "frame 11");
  both.parameters.erase("POINT:LONG_FRAMES");
  CHECK(rows(both) == many);
  // Where two frame counts contradict each other, the one that fills the file is used.
  both.integers("POINT:FRAMES", {70'000 - 65'536});
  CHECK(rows(both) == many);
  both.integers("TRIAL:ACTUAL_END_FIELD", {5'000, 0});
  check_error([&] { rows(both); }, Code::file_damaged);
  both.integers("POINT:FRAMES", {40'000});
  both.parameters.erase("TRIAL:ACTUAL_END_FIELD");
  CHECK(rows(both) == 40'000);
  REQUIRE(table_for(both).warnings().size() == 1);
  CHECK(table_for(both).warnings()[0].code == "frames_left_out");
  both.reals("POINT:FRAMES", {30'000.0});
  CHECK(rows(both) == 30'000);
  for (const double none : {0.0, 2.5, -1e30}) {
    both.reals("POINT:FRAMES", {none});
    check_error([&] { rows(both); }, Code::file_damaged);
  }
}

TEST_CASE("C3D: stored frames that are not counted give a note, padding does not") {
  const auto left_out = [](int counted, std::size_t stored) {
    C3dFile file(intel, false);  // 8 bytes a frame
    file.point("COM", signal(900, 40, stored), still(stored), still(stored));
    file.integers("POINT:FRAMES", {counted});
    const Recording recording = read(file.bytes(), {.column = "COM_x", .com_height_m = 0.9});
    CHECK(recording.signals.samples() == static_cast<std::size_t>(counted));
    const auto found = std::ranges::find(recording.warnings, "frames_left_out", &Warning::code);
    if (found == recording.warnings.end()) return std::string();
    CHECK(found->severity == Severity::caution);
    return found->text;
  };
  CHECK(contains(left_out(100, 12'000), "stores 12000"));
  CHECK(contains(left_out(100, 165), "stores 165"));
  CHECK(left_out(100, 128) == "");  // the block's end
  CHECK(left_out(100, 100) == "");
  // Parameters behind the data are no frames.
  std::string bytes = trial(intel, false).bytes();
  const std::size_t block = C3dFile::block, data = (static_cast<unsigned char>(bytes[16]) - 1U) * block;
  const std::string section = bytes.substr(block, data - block);
  const std::size_t data_blocks = (bytes.size() - data) / block;
  bytes = bytes.substr(0, block) + bytes.substr(data) + section;
  bytes[0] = static_cast<char>(2 + data_blocks);
  bytes[16] = 2;
  CHECK(C3dTable(bytes, "r.c3d").warnings().empty());
}

TEST_CASE("C3D: files that are cut short, anywhere") {
  const std::string bytes = trial(dec, false).bytes();
  for (std::size_t length = 0; length < bytes.size(); length += C3dFile::block / 8) {
    // Behind the last frame the last block is filled up.
    if (bytes.size() - length < C3dFile::block) break;
    CAPTURE(length);
    check_error(reading(bytes.substr(0, length)), Code::file_damaged, "r.c3d");
  }
  check_error(reading(""), Code::file_damaged, "not a C3D file");
  check_error(reading("time,sway_deg\n0,1\n" + std::string(600, ' ')), Code::file_damaged, "not a C3D file");
}

TEST_CASE("C3D: bounds of a file's counts") {
  C3dFile file = trial(intel, true);
  const std::string bytes = file.bytes();
  const auto header = [&](std::size_t at, int value) {
    std::string changed = bytes;
    put(changed, at, file.word(value));
    return changed;
  };
  check_error(reading(header(0, 0x5000)), Code::file_damaged, "not a C3D file");
  check_error(reading(header(0, 0x50FF)), Code::file_damaged);
  check_error(reading(header(2, 4)), Code::file_damaged);
  check_error(reading(header(4, 2)), Code::file_damaged);
  check_error(reading(header(16, 0)), Code::file_damaged);
  check_error(reading(header(16, 99)), Code::file_damaged);
  check_error(reading(header(18, 2)), Code::file_damaged, "2 samples");
  check_error(reading(header(14, 0x3C00)), Code::file_damaged);
  for (const int processor : {0, 83, 87}) {
    std::string changed = bytes;
    changed[C3dFile::block + 3] = static_cast<char>(processor);
    check_error(reading(changed), Code::file_damaged, "84");
  }
  for (const auto& [name, values, part] : {std::tuple{"POINT:USED", 4, "POINT:USED"},
                                           {"POINT:USED", -1, "POINT:USED"},
                                           {"ANALOG:USED", 3, "ANALOG:USED"},
                                           {"POINT:DATA_START", 9, "POINT:DATA_START"},
                                           {"POINT:FRAMES", 500, "should have 500 frames"},
                                           {"POINT:FRAMES", -3, "should have 65533 frames"}}) {
    C3dFile other = trial(intel, true);
    other.integers(name, {values});
    check_error(reading(other.bytes()), Code::file_damaged, part);
  }
  C3dFile zero = trial(intel, false);
  zero.reals("POINT:SCALE", {0.0});
  check_error(reading(zero.bytes()), Code::file_damaged);
  // Records of the parameters.
  for (const auto& [body, part] : {std::pair{std::string{3, 0}, "unknown type 3"},
                                   {std::string{2, 7} + std::string(7, '\xff'), "longer than the file"},
                                   {std::string{2, 1, 20}, "overlaps the next one"},
                                   {std::string{2}, "damaged"}}) {
    C3dFile other = trial(intel, true);
    other.parameters["POINT:A"] = body;
    check_error(reading(other.bytes()), Code::file_damaged, part);
  }
  C3dFile empty;
  empty.channel("a", "deg", {});
  std::string nothing = empty.bytes();
  put(nothing, 4, empty.word(0));
  check_error([&] { C3dTable(nothing, "r.c3d"); }, Code::file_empty);
  C3dFile wide = trial(intel, true);
  wide.integers("POINT:USED", {3400});
  std::string points = wide.bytes();
  put(points, 2, wide.word(3400));
  check_error(reading(points), Code::file_too_large, "10201 columns");
}
