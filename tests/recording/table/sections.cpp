// Text files that hold several tables.
#include "recording/table/detail/sections.hpp"

#include <cmath>

#include "tests/recording/table/reading.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

const std::string vicon =
    "Devices,,,\n1000\n,,Force,\nFrame,Sub Frame,Fx,Fy\n,,N,N\n1,0,1,2\n1,1,1,2\n1,2,1,2\n\n"
    "Model Outputs\n100\n,,COM,\nFrame,Sub Frame,angle,y\n,,deg,mm\n1,0,1,1\n2,0,2,1\n3,0,3,1\n,,,\n"
    "Trajectories\n100\n,,ANK,\nFrame,Sub Frame,X,Y\n,,mm,mm\n1,0,101,1\n2,0,111,1\n3,0,121,1\n";

/// Two blocks of LabChart, of 100 Hz and of 50 Hz.
const std::string labchart =
    "Interval=\t0.01 s\nChannelTitle=\tSway\tPlatform\nRange=\t10 V\t10 V\n0\t1\t0\n0.01\t2\t0\n0.02\t3\t0\n"
    "Interval=\t0.02 s\nChannelTitle=\tSway\tPlatform\nRange=\t10 V\t10 V\n0\t4\t0\n0.02\t5\t0\n0.04\t6\t0\n";

RecordingOptions section(const std::string& name, const std::string& column = {}) {
  RecordingOptions options;
  options.section = name;
  options.column = column;
  options.find_tilt = false;
  return options;
}

}  // namespace

TEST_CASE("a section is chosen by its name or number, and lines keep their numbers") {
  check_error(reading(vicon), Code::recording_ambiguous, "line 10");
  for (const char* name : {"Model Outputs", "model outputs", "2"}) {
    CAPTURE(name);
    check_one_two_three(vicon, section(name, "angle"));
  }
  RecordingOptions markers = section("Trajectories", "X");
  markers.com_height_m = 1.0;
  markers.ankle_column = "Y";
  const Recording recording = read(vicon, markers);
  CHECK(recording.rate_hz == 100.0);
  CHECK(near(recording.signals.at(com_sway).rad[2], std::asin(0.12), 1e-12));
  std::string wrong = vicon;
  wrong.replace(wrong.find("2,0,2,1"), 7, "2,0,x,1");
  check_error(reading(wrong, section("2", "angle")), Code::value_invalid, "line 16, angle (deg)");
  check_error(reading(vicon, section("Joints")), Code::setting_unknown, "'Trajectories'");
  check_error(reading(vicon, section("4")), Code::setting_unknown, "has no section 4");
  check_error(reading(vicon, section("0")), Code::setting_unknown, "has no section 0");
  check_error(reading(vicon + "\n" + vicon, section("devices")), Code::recording_ambiguous, "'devices'");
}

TEST_CASE("blocks of LabChart are sections, each with its rate") {
  check_error(reading(labchart), Code::recording_ambiguous, "line 1");
  check_one_two_three(labchart, section("1", "Sway"));
  const Recording second = read(labchart, section("2", "Sway"));
  CHECK(second.rate_hz == 50.0);
  CHECK(second.signals.at(com_sway).rad[0] == 4.0 * sim::rad_per_deg);
}

TEST_CASE("a footer is no section: --section 1 leaves it out") {
  const std::string text = "time,sway_deg\n0,1\n0.01,2\n0.02,3\n\nMean,2\nSD,1\n";
  check_error(reading(text), Code::table_unclear, "line 6");
  check_one_two_three(text, section("1"));
}

TEST_CASE("a table whose first column is text is one table, also behind blank lines and comments") {
  std::string rows, dates, events = "event,time,sway_deg\n";
  for (int k = 0; k < 40; ++k) {
    const std::string values = std::to_string(k * 0.01) + "," + std::to_string(k % 5);
    const std::string between = k % 10 == 9 ? "\n" : k % 10 == 4 ? "# pause\n" : "";
    rows += (k < 20 ? "s01," : "s02,") + values + "\n" + between;
    dates += "2026-03-05 10:00:0" + values + "\n" + between;
    events += (k % 10 == 0 ? "step," : ",") + values + "\n" + between;
  }
  const std::string subjects = "label,time,sway_deg\n" + rows;
  CHECK(find_sections(subjects).size() == 1);
  CHECK(read(subjects).signals.samples() == 40);
  CHECK(read(subjects, section("1")).signals.samples() == 40);
  CHECK(find_sections(events).size() == 1);
  CHECK(read(events).signals.samples() == 40);
  // Their footers are left out as well, and another table is a section.
  for (const std::string& table : {subjects, "time,sway_deg\n" + dates}) {
    check_error(reading(table + "\nMean,2\n"), Code::table_unclear, "'Mean,2'");
    CHECK(read(table + "\nMean,2\n", section("1")).signals.samples() == 40);
  }
  CHECK(find_sections(subjects + "\n" + subjects).size() == 2);
  check_error(reading(subjects + "\n" + subjects), Code::recording_ambiguous, "line 1");
  CHECK(read(subjects + "\n" + subjects, section("2")).signals.samples() == 40);
}

TEST_CASE("files joined with their headers are sections") {
  const std::string one = "time,sway_deg\ns,deg\n0,1\n0.01,2\n0.02,3\n";
  check_error(reading(one + one), Code::recording_ambiguous, "line 1");
  for (const char* number : {"1", "2"}) check_one_two_three(one + one, section(number));
}

TEST_CASE("--section 1 is not advised where it would not leave the lines out") {
  const std::string few = "id,time,sway_deg\na,0,1\na,0.01,2\na,0.02,3\n\nMean,2\n";
  const Error error = error_of(reading(few));
  CHECK(contains(error.problem(), "from line 6 on: 'Mean,2'"));
  CHECK_FALSE(contains(error.remedy(), "section"));
  check_one_two_three("id,time,sway_deg\na,0,1\na,0.01,2\na,0.02,3\n\n# Mean,2\n", {.column = "sway_deg"});
}
