// Motion recordings of BIDS: columns and rate come from the files beside them.
#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>

#include "base/text.hpp"
#include "recording/recording.hpp"
#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::test;

namespace {

std::string samples(bool with_time) {
  std::string text;
  for (int i = 0; i < 400; ++i)
    text += (with_time ? format("%.3f\t", 0.02 * i) : std::string()) +
            format("%.5f\t%.4f\tn/a\n", std::sin(0.05 * i), 0.9 + 0.001 * i);
  return text;
}

const char* const channels =
    "name\tcomponent\ttype\ttracked_point\tunits\ncom_sway\tn/a\tJNTANG\tbody\tdeg\nhip_z\tz\tPOS\thip\tm\nextra\tn/"
    "a\tMISC\tn/a\tn/a\n";

}  // namespace

TEST_CASE("motion-BIDS: names, units and the rate, also from the data set's folder") {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "sub-01/motion");
  const std::string stem = "sub-01/motion/sub-01_task-sway_tracksys-imu";
  const std::filesystem::path motion = write_text(folder / (stem + "_motion.tsv"), samples(false));
  write_text(folder / (stem + "_channels.tsv"), channels);
  write_text(folder / "task-sway_motion.json", R"({"SamplingFrequency": 50, "TaskName": "sway"})");
  write_text(folder / "task-walk_motion.json", R"({"SamplingFrequency": 10})");
  const recording::Recording read = recording::read_recording(motion, {});
  CHECK(read.rate_hz == 50.0);
  const auto& sway = read.signals.at(recording::com_sway);
  CHECK(sway.column == "com_sway (deg)");
  CHECK(near(sway.rad[100], std::sin(5.0) * std::acos(-1.0) / 180.0, 1e-4));
  // The encodings that tables have: UTF-8 with a mark, and UTF-16.
  std::string wide = "\xFF\xFE";
  for (const char* c = channels; *c != '\0'; ++c) wide += {*c, '\0'};
  for (const std::string& text : {"\xEF\xBB\xBF" + std::string(channels), wide}) {
    write_text(folder / (stem + "_channels.tsv"), text);
    CHECK(recording::read_recording(motion, {}).signals.at(recording::com_sway).column == "com_sway (deg)");
  }
  write_text(folder / (stem + "_channels.tsv"), channels);
  recording::RecordingOptions third;
  third.column = "extra";
  check_error([&] { recording::read_recording(motion, third); }, Code::value_missing);  // n/a

  write_text(folder / (stem + "_channels.tsv"),
             std::string("name\tcomponent\ttype\ttracked_point\tunits\nclock\tn/a\tLATENCY\tn/a\ts\n") +
                 std::string(channels).substr(std::string(channels).find('\n') + 1));
  write_text(motion, samples(true));
  CHECK(near(recording::read_recording(motion, {}).rate_hz, 50.0, 1e-6));

  std::string two = samples(true);
  int row = 0;
  for (std::size_t at = 0; (at = two.find("n/a")) != std::string::npos; ++row)
    two.replace(at, 3, row < 200 ? "1" : "2");
  write_text(motion, two);
  CHECK(contains(recording::read_recording(motion, {}).change, "'extra' changes from '1' to '2' at 4 s"));
}

TEST_CASE("motion-BIDS: channels that do not fit are refused, other files are read as before") {
  const TemporaryFolder folder;
  const std::filesystem::path motion = write_text(folder / "a_motion.tsv", samples(false));
  check_error([&] { recording::read_recording(motion, {}); }, Code::column_ambiguous);  // no channels
  write_text(folder / "a_channels.tsv", "name\ttype\ncom_sway\tJNTANG\n");
  check_error([&] { recording::read_recording(motion, {}); }, Code::file_damaged, "3 columns");
  write_text(folder / "a_channels.tsv", "type\nJNTANG\n");
  check_error([&] { recording::read_recording(motion, {}); }, Code::column_missing, "name");
  write_text(folder / "a_channels.tsv", "name\ttype\ncom_sway\n");
  check_error([&] { recording::read_recording(motion, {}); }, Code::file_damaged, "line 2");
  write_text(folder / "a_channels.tsv", channels);
  write_text(folder / "a_motion.json", R"({"SamplingFrequency": "fast"})");
  check_error([&] { recording::read_recording(motion, {}); }, Code::value_invalid, "SamplingFrequency");
  const std::filesystem::path named = write_text(folder / "b_motion.tsv", "time\tcom_sway_deg\tx\n" + samples(true));
  check_error([&] { recording::read_recording(named, {}); }, Code::table_unclear);  // four cells below three names
}
