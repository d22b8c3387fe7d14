// Exports of other programs: formats, clocks, counters, missing values, angles that wrap.
#include <cmath>
#include <cstdio>
#include <string>

#include "recording/formats/detail/foreign.hpp"
#include "tests/recording/table/reading.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

/// 1, 2, 3 degrees under this header, with these times.
std::string three(const std::string& header, const std::string& a, const std::string& b, const std::string& c) {
  return header + "\n" + a + ",1\n" + b + ",2\n" + c + ",3\n";
}

}  // namespace

TEST_CASE("files of other programs are named in the error") {
  using namespace std::string_literals;
  std::string c3d(512, '\0');
  c3d[0] = 2;
  c3d[1] = '\x50';
  for (const auto& one : {std::pair{"TDSm\x0E"s, "TDMS"},
                          {"PAR1\x15"s, "Parquet"},
                          {"\x93NUMPY\x01"s, ".npy"},
                          {"\x1F\x8B\x08"s, "gzip"},
                          {"version https://git-lfs.github.com/spec/v1\n"s, "Git LFS"},
                          {"%PDF-1.4\n"s, "PDF"},
                          {"$FL2@(#)"s, "SPSS"},
                          {"#ROSBAG V2.0\n"s, "ROS"},
                          {"ADInstr\0"s, "LabChart"},
                          {"ARROW1\0\0"s, "Arrow"},
                          {"\xD0\xCF\x11\xE0"s, ".xls"},
                          {"PK\x03\x04....xl/worksheets/sheet1.bin"s, "Excel"},
                          {"PK\x03\x04mimetypeapplication/vnd.oasis.opendocument"s, "OpenDocument"},
                          {"PK\x03\x04...."s, "ZIP"},
                          {"PK\x03\x04....time.npy"s, "NumPy arrays (.npz)"},
                          {"PK\x03\x04....sway.npy....parameters.npy"s, "an evaluation takes the data set as data"},
                          {"<?xml?>\n<mvnx version=\"4\">"s, "MVN"},
                          {"<html><table>"s, "HTML"},
                          {"<a/>"s, "XML"},
                          {"[{\"time\":0}]"s, "JSON"},
                          {c3d, "C3D"}}) {
    const char* const what = one.second;  // clang 14 captures no structured binding
    CAPTURE(what);
    check_error(reading(one.first), one.first == c3d ? Code::file_damaged : Code::file_unsupported, what);
  }
  check_error([] { refuse_foreign(std::string("\x00\x54\x00", 3), "a.acq", ".acq"); }, Code::file_unsupported);
  refuse_foreign("0       1.5\n0.01    1.6\n", "t.txt", ".txt");  // which is no EDF file
  refuse_foreign("[s],[deg]\n0,1\n", "t.csv", ".csv");
}

TEST_CASE("nulls at the end, and minus signs of Unicode") {
  check_one_two_three("time,sway_deg\n0,1\n0.01,2\n0.02,3\n" + std::string(100, '\0'));
  CHECK(read("time,sway_deg\n0,\xE2\x88\x92"
             "1\n0.01,2\n0.02,\xE2\x88\x92"
             "3\n")
            .signals.at(com_sway)
            .rad[2] == -3.0 * sim::rad_per_deg);
}

TEST_CASE("columns of time by their names") {
  for (const char* name : {"ElapsedTime", "Elapsed Time (s)", "MocapTime", "Sample Time", "rel_time_s", "Time"})
    check_one_two_three(three(name + std::string(",sway_deg"), "0", "0.01", "0.02"));
  check_error(reading(three("T [C],sway_deg", "36.5", "36.5", "36.5")), Code::rate_unknown);
  check_one_two_three(three("time_ns,sway_deg", "1600000000000000000", "1600000000010000000", "1600000000020000000"));
  // Unix times say their unit themselves, until 2096.
  check_one_two_three(three("%time,sway_deg", "1732876342100000000", "1732876342110000000", "1732876342120000000"));
  check_one_two_three(three("timestamp,sway_deg", "1732876342100000", "1732876342110000", "1732876342120000"));
  check_one_two_three(three("t,sway_deg", "1732876342100", "1732876342110", "1732876342120"));
  check_one_two_three(three("time_s,sway_deg", "1732876342.1", "1732876342.11", "1732876342.12"));
  check_error(reading(three("t,sway_deg", "5000000000000", "5000000000010", "5000000000020")),
              Code::setting_out_of_range, "t_ms");
  check_error(reading(three("timestamp,sway_deg", "0", "10000000", "20000000")), Code::setting_out_of_range,
              "timestamp_ns");
  check_error(reading(three("time,sway_deg", "0", "10", "20")), Code::setting_out_of_range, "time_ms");
}

TEST_CASE("counters, forces and quaternions are not sway; the remaining column is") {
  for (const char* text :
       {",time,angle_deg\n0,0,1\n1,0.01,2\n2,0.02,3\n", "Frame,Time,angle_deg\n7,0,1\n8,0.01,2\n9,0.02,3\n",
        "Unnamed: 0,time,angle_deg\n0,0,1\n1,0.01,2\n2,0.02,3\n",
        "time,angle_deg,Fz (N),q0,CoPx\n0,1,7,1,1\n0.01,2,7,1,1\n0.02,3,7,1,1\n"}) {
    check_one_two_three(text);
    CHECK(has(read(text).warnings, "column_assumed"));
  }
  check_error(reading("PacketCounter,Roll,Pitch\n1,0,1\n2,0,2\n"), Code::column_ambiguous, "'Roll', 'Pitch'");
}

TEST_CASE("parts of quaternions are not sway, by their names or their values, also if they are named") {
  const auto quaternion = [](const std::string& header, const std::string& before = "") {
    std::string text = header + "\n";
    char row[96];
    for (int k = 0; k < 30; ++k) {
      const double half = 0.5 * sim::rad_per_deg * std::sin(0.3 * k);
      std::snprintf(row, sizeof row, "%.2f,%s%.7f,%.7f,%.7f,%.7f\n", 0.01 * k, before.c_str(), std::cos(half), 0.0,
                    std::sin(half), 0.0);
      text += row;
    }
    return text;
  };
  const RecordingOptions named{.column = "4", .unit = Unit::radian};
  for (const char* header : {"time,qw,qx,qy,qz", "time,Quat_W,Quat_X,Quat_Y,Quat_Z", "time,q0,q1,q2,q3",
                             "time,ori.a,ori.b,ori.c,ori.d", "time,q1,q2,q3,q4"}) {
    CAPTURE(std::string(header));
    check_error(reading(quaternion(header)), Code::column_unsuitable, "quaternion");
    check_error(reading(quaternion(header), named), Code::column_unsuitable, "quaternion");
  }
  check_error(reading(quaternion("time,Frame,q0,q1,q2,q3", "5,")), Code::column_unsuitable, "quaternion");
  check_one_two_three("time,sway_deg,qw,qx,qy,qz\n0,1,1,0,0,0\n0.01,2,1,0,0,0\n0.02,3,1,0,0,0\n");
  // Angles of a quaternion, joints of a robot, and three small angles beside a constant 1.
  check_one_two_three("time,quat_pitch_deg,qw\n0,1,1\n0.01,2,1\n0.02,3,1\n");
  check_one_two_three("time,q1,q2\n0,1,1\n0.01,2,1\n0.02,3,1\n", {.column = "q1"});
  const std::string beside = "time,level,a,b,c\n0,1,0.01,0,0\n0.01,1,0.02,0,0\n0.02,1,0.03,0,0\n";
  CHECK(read(beside, {.column = "a", .unit = Unit::radian}).signals.at(com_sway).rad[1] == 0.02);
}

TEST_CASE("names of tilts and sways") {
  for (const char* name :
       {"stim_pitch", "surface_tilt_deg", "SS", "platform pitch (deg)", "base_angle", "Support Surface Angle"}) {
    CAPTURE(std::string(name));
    const Recording recording = read("time,sway_deg," + std::string(name) + "\n0,1,0\n0.01,2,1\n0.02,3,2\n");
    REQUIRE(recording.signals.find(platform_tilt) != nullptr);
    CHECK(recording.signals.at(platform_tilt).column == name);
  }
  for (const char* name : {"COG_x", "body sway angle", "BodySway", "SwayAP", "Neigung_Grad", "lean_angle_deg"})
    check_one_two_three("time,other," + std::string(name) + "\n0,5,1\n0.01,5,2\n0.02,5,3\n", {.unit = Unit::degree});
}

TEST_CASE("numbers that stand for missing values") {
  const auto text = [](const std::string& mark) { return "time,sway_deg\n0,1\n0.01," + mark + "\n0.02,3\n"; };
  for (const char* mark : {"9999", "-9999", "-9.99e+33", "-3.697314E+28", "1E+30", "None", "missing", "?", "NA"}) {
    CAPTURE(std::string(mark));
    check_one_two_three(text(mark), {.fill_gaps_s = 0.02});
    check_error(reading(text(mark)), Code::value_missing, "fill_gaps");
  }
  check_one_two_three(text("77"), {.missing_value = 77.0, .fill_gaps_s = 0.02});
  check_error(reading(text("9998")), Code::value_invalid);
}

TEST_CASE("angles that wrap, and those that are 90 or 180 degrees upright") {
  const auto sway = [](const std::string& text, const RecordingOptions& options = {}) {
    return read(text, options).signals.at(com_sway).rad;
  };
  const auto wrapped = sway(three("time,sway_deg", "0,359\n0.01", "0.02", "0.03"));
  REQUIRE(wrapped.size() == 4);
  CHECK(test::within(wrapped[0], -1.0 * sim::rad_per_deg, 1e-12));
  CHECK(has(read(three("time,sway_deg", "0,359\n0.01", "0.02", "0.03")).warnings, "unwrapped"));
  const std::string upside = "time,sway_deg\n0,179\n0.01,-180\n0.02,-179\n",
                    upright = "time,sway_deg\n0,89\n0.01,91\n0.02,90\n";
  for (const std::string& text : {upside, upright}) {
    check_error(reading(text), Code::value_invalid);
    CHECK(sway(text, {.mean_is_upright = true}).size() == 3);
  }
}

TEST_CASE("bars separate cells, and comments above a header state the rate") {
  check_one_two_three("time|sway_deg\n0|1\n0.01|2\n0.02|3\n");
  check_one_two_three("# made by lab\n# fs = 100 Hz\nsway_deg\n1\n2\n3\n");
}

TEST_CASE("angles in other units than degrees and radians are refused by their names") {
  for (const char* unit : {"gon", "arcmin", "mdeg", "turns"}) {
    const std::string text = std::string("time,sway (") + unit + ")\n0,1\n0.01,2\n0.02,3\n";
    check_error(reading(text), Code::unit_unknown, unit);
    check_one_two_three(text, {.unit = Unit::degree});
  }
}

TEST_CASE("R's write.table names no column of row names") {
  check_one_two_three("\"time\" \"sway_deg\"\n\"1\" 0 1\n\"2\" 0.01 2\n\"3\" 0.02 3\n");
  check_one_two_three("time\tsway_deg\n1\t0\t1\n2\t0.01\t2\n3\t0.02\t3\n");
}
