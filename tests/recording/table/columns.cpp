// Column names: units, quantities that are not a sway angle, times; and a column chosen by name.
#include "recording/table/columns.hpp"

#include <string>

#include "recording/formats/csv.hpp"
#include "tests/recording/table/reading.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

std::string quantity(const char* name) {
  const char* found = other_quantity(name);
  return found != nullptr ? found : "";
}

}  // namespace

TEST_CASE("columns: quantities that are no angle are known by their names and units") {
  CHECK(quantity("sway (mV)") == "a voltage");
  CHECK(quantity("Fz [kN]") == "a force");
  for (const char* name : {"Fz", "FP1_Fx", "FY", "Force_x", "Force.Fy2"}) CHECK(quantity(name) == "a force");
  for (const char* name : {"My", "MX1", "FP1_Mz", "Moment_y"}) CHECK(quantity(name) == "a torque");
  CHECK(quantity("data.My") == "a torque");
  for (const char* name : {"CoMx", "COMy", "my_deg", "M1x", "my angle", "my_sway", "My data", "My lean", "mein Winkel",
                           "MyCOM", "my com x"})
    CHECK(quantity(name).empty());
  CHECK(quantity("ankle (N.m)") == "a torque");
  CHECK(quantity("COM (mm/s)") == "a velocity");
  CHECK(quantity("trunk (m/s^2)") == "an acceleration");
  CHECK(quantity("subject (kg)") == "a mass");
  CHECK(quantity("load [%]") == "a fraction");
  CHECK(quantity("sway_mm") == "a length");
  CHECK(quantity("CoP AP") == centre_of_pressure);
  for (const char* name : {"sway deg per s", "sway deg/s", "sway_deg_s", "sway (rad/s)", "sway_mrad_per_s",
                           "angularVelocity", "sway speed", "gyro x", "sway_dps", "SwayVel", "swayvel", "sway_dot"})
    CHECK(quantity(name) == "a velocity");
  for (const char* name : {"pitch_rate", "pitchRate", "pitchrate", "sway_rate_deg", "body_rate", "imu.pitch_rate_rad",
                           "dpitch", "omega", "omega_y_rad", "wy", "imu.wy"})
    CHECK(quantity(name) == "a velocity");
  for (const char* name : {"rate", "sample_rate", "frame rate", "body_sample_rate", "sway sampling rate", "deg", "d",
                           "separate", "way", "sway_y"}) {
    CAPTURE(name);
    CHECK(quantity(name).empty());
  }
  CHECK(quantity("rate_hz") == "a frequency");
  for (const char* name :
       {"sway deg/s2", "sway deg/s^2", "sway (rad/s2)", "angular acceleration", "sway_acceleration", "sway_ddot"})
    CHECK(quantity(name) == "an acceleration");
  CHECK(quantity("AnkleTorque") == "a torque");
  CHECK(quantity("sway_std") == "a standard deviation");
  CHECK(quantity("temperature") == "a temperature");
  for (const std::string angle :
       {"sway", "sway (deg)", "sway [rad]", "sway)", "sway ()", "per s", "deg", "x per s", "(V", "sway deg 2"}) {
    INFO(angle);
    CHECK(quantity(angle.c_str()).empty());
  }
}

TEST_CASE("columns: units that are neither of an angle nor of a length in mm, cm or m") {
  for (const auto& [name, expected] : {std::pair{"sway (in)", "a length in neither mm, cm nor m"},
                                       {"sway [ inch ]", "a length in neither mm, cm nor m"},
                                       {"COM_x (ft)", "a length in neither mm, cm nor m"},
                                       {"sway (\xC2\xB5m)", "a length in neither mm, cm nor m"},
                                       {"sway_inches", "a length in neither mm, cm nor m"},
                                       {"sway (counts)", "in counts"},
                                       {"sway (a.u.)", "in arbitrary units"},
                                       {"sway [A. U.]", "in arbitrary units"},
                                       {"sway (px)", "in pixels"},
                                       {"sway_pixels", "in pixels"},
                                       {"load (lbs)", "a force"},
                                       {"sway (dB)", "in decibels"},
                                       {"sway (mA)", "a current"},
                                       {"sway (\u00B5A)", "a current"},
                                       {"sway (\u00B0C)", "a temperature"},
                                       {"sway (%BW)", "a fraction"},
                                       {"sway (% BW)", "a fraction"},
                                       {"sway_percent", "a fraction"},
                                       {"sway (Hz)", "a frequency"},
                                       {"sway_mV", "a voltage"},
                                       {"sway_uV", "a voltage"},
                                       {"sway_\u00B5V", "a voltage"},
                                       {"sway_volt", "a voltage"}}) {
    const char* const column = name;
    CAPTURE(std::string(column));
    CHECK(quantity(column) == expected);
  }
  // An axis, a side, a number, a device; letters that are a unit in brackets only.
  for (const char* name : {"sway (x)", "sway (left)", "sway (ML)", "sway (AP)", "sway (2)", "sway (Vicon)",
                           "sway [IMU 3]", "sway ( )", "sway_in", "sway_PA", "sway_ma", "sway_v", "mV", "percent"}) {
    CAPTURE(std::string(name));
    CHECK(quantity(name).empty());
  }
}

TEST_CASE("columns: units of length and angle in the plural") {
  for (const auto& [name, metres] : {std::pair{"COM_x (millimeters)", 1e-3},
                                     {"COM_x (millimetres)", 1e-3},
                                     {"COM_x_centimeters", 1e-2},
                                     {"COM_x [centimetres]", 1e-2},
                                     {"COM_x meters", 1.0},
                                     {"COM_x metres", 1.0}}) {
    const char* const column = name;
    CAPTURE(std::string(column));
    CHECK(find_metres_per_unit(column) == metres);
    CHECK(quantity(column) == "a length");
  }
  CHECK(unit_in("sway (degrees)") == Unit::degree);
  CHECK(unit_in("sway_radians") == Unit::radian);
}

TEST_CASE("columns: capitals begin words, in names and not in units") {
  using Words = std::vector<std::string>;
  CHECK(words_in("LAnkleAngle_deg") == Words{"lankleangle", "deg", "l", "ankle", "angle"});
  CHECK(words_in("COMAngle") == Words{"comangle", "com", "angle"});
  CHECK(words_in("CoMAngle") == Words{"comangle", "com", "angle"});
  CHECK(words_in("com_sway") == Words{"com", "sway"});
  CHECK(words_in("") == Words{""});
  CHECK(words("sway (mDeg)") == Words{"sway", "mdeg"});
}

TEST_CASE("columns: names without their units") {
  CHECK(name_before_unit("KSP (deg)") == "KSP");
  CHECK(name_before_unit("KSP  [deg]") == "KSP");
  for (const char* whole : {"", "KSP", "KSP)", "(deg)", "KSP (deg) x"}) CHECK(name_before_unit(whole) == whole);
}

TEST_CASE("columns: one is named as it stands, in another case, without its unit, or by its number") {
  const CsvTable table("t,Sway (deg),sway,7\n0,1,2,3\n1,1,2,3\n", "t.csv");
  const auto named = [&](const char* name) { return named_column(table, name, "t.csv", "column"); };
  CHECK(named("sway") == 2);
  CHECK(named("SWAY") == 2);
  CHECK(named("Sway (deg)") == 1);
  CHECK(named("1") == 0);
  CHECK(named("7") == 3);  // a name before a number
  for (const char* none : {"0", "5", "-1", "2x", "swa", "99999999999", ""}) {
    INFO(none);
    check_error([&] { named(none); }, Code::column_missing, "from 1, as column");
  }
  const CsvTable numbers("time,1_deg,2_deg,3_deg\n0,1,2,3\n1,1,2,3\n", "t.csv");
  CHECK(named_column(numbers, "2", "t.csv", "column") == 1);
  CHECK(named_column(numbers, "2_deg", "t.csv", "column") == 2);
  const CsvTable subject("t,Sub1:HIP X (mm),Sub1:HIP Y (mm),Sub2:SHO (mm),Sub1:SHO (mm)\n0,1,2,3,4\n1,1,2,3,4\n",
                         "t.csv");
  CHECK(named_column(subject, "HIP X", "t.csv", "hip") == 1);
  CHECK(named_column(subject, "hip_y", "t.csv", "hip") == 2);
  CHECK(named_column(subject, "Sub2:SHO", "t.csv", "hip") == 3);
  check_error([&] { named_column(subject, "SHO", "t.csv", "hip"); }, Code::column_ambiguous, "4 and 5");
  const CsvTable markers("t,LHIP_x_mm,RHIP_x_mm,SHO_mm,SHO_cm,C7\n0,1,2,3,4,5\n1,1,2,3,4,5\n", "t.csv");
  const auto marker = [&](const char* name) { return named_column(markers, name, "t.csv", "hip"); };
  CHECK(marker("LHIP_x") == 1);
  CHECK(marker("rhip x") == 2);
  check_error([&] { marker("SHO"); }, Code::column_ambiguous, "numbers 4 and 5");
  check_error([&] { marker("HIP_x"); }, Code::column_missing,
              "has no column 'HIP_x'; its columns are 't', 'LHIP_x_mm'");
  check_error([&] { marker("LHIP_x,RHIP_x"); }, Code::column_missing,
              "decid does not average columns, as those of left and right; name one column as hip");
  const CsvTable twice("a,A\n1,2\n3,4\n", "t.csv");
  check_error([&] { named_column(twice, "a (x)", "t.csv", "column"); }, Code::column_missing);
  CHECK(named_column(twice, "a", "t.csv", "column") == 0);
  const CsvTable same("a,a,a\n1,2,3\n3,4,5\n", "t.csv");
  check_error([&] { named_column(same, "a", "t.csv", "column"); }, Code::column_ambiguous, "'a'");
}

TEST_CASE("columns: a long list of names is cut") {
  std::string header = "t", row = "0";
  for (int k = 0; k < 60; ++k) {
    header += ",signal_" + std::to_string(k);
    row += ",1";
  }
  const CsvTable table(header + "\n" + row + "\n" + row + "\n", "t.csv");
  const std::string list = to_list(table, 0);
  CHECK(list.starts_with("'signal_0', 'signal_1'"));
  CHECK(list.ends_with(", ..."));
  CHECK(list.size() < 230);
}

TEST_CASE("columns: without a header a first column that rises evenly is time") {
  const auto time_of = [](const char* text) { return find_time(CsvTable(text, "t.csv")); };
  CHECK(time_of("0 5\n1 5\n2 6\n") == 0);
  CHECK(time_of("0 5\n1 5\n") == -1);       // too few to tell
  CHECK(time_of("0 5\n1 5\n9 6\n") == -1);  // uneven
  CHECK(time_of("2 5\n1 5\n0 6\n") == -1);  // falls
  CHECK(time_of("0\n1\n2\n") == -1);        // alone
  CHECK(time_of("0 5\nnan 5\n2 6\n") == -1);
  CHECK(time_of("0;5\n;5\n2;6\n") == -1);
  CHECK(time_of("a,b\n0,5\n1,5\n2,6\n") == -1);
  CHECK(time_of("a,t_x\n0,5\n1,5\n2,6\n") == 1);
}

TEST_CASE("columns: Delsys' X [s] is a time, other abscissas are not") {
  CHECK(is_time_name("X [s]"));
  CHECK(is_time_name("X (s)"));
  for (const char* name : {"X", "X (mm)", "X s", "HIP X [s]", "Latency [s]"}) CHECK_FALSE(is_time_name(name));
}

TEST_CASE("columns: ROS's header.stamp is the time if no column is called so, and no sway") {
  const auto time_of = [](const char* text) { return find_time(CsvTable(text, "t.csv")); };
  CHECK(time_of("header.seq,header.stamp,pitch\n0,5,1\n1,6,2\n") == 1);
  CHECK(time_of("header.stamp.sec,header.stamp.nanosec,pitch\n0,5,1\n1,6,2\n") == 0);
  CHECK(time_of("header.stamp.nanosec,header.stamp.sec,pitch\n0,5,1\n1,6,2\n") == 1);
  CHECK(time_of("header.stamp,time,pitch\n0,5,1\n1,6,2\n") == 1);
  CHECK(time_of("stamped,pitch\n0,5\n1,6\n") == -1);
  const std::string rows = "\n5,0,0.00,7,1\n5,1,0.01,8,2\n5,2,0.02,9,3\n";
  check_one_two_three("field.header.stamp.secs,field.header.seq,%time,header.stamp.nsecs,field.pitch_deg" + rows);
}

TEST_CASE("columns: milliradians in words, and units before the name") {
  for (const char* name : {"sway [millirad]", "sway (mrad)", "mrad_sway", "sway_mrad"}) {
    CAPTURE(std::string(name));
    CHECK(find_unit(name, {}, "t", "unit") == Unit::milliradian);
    CHECK(name_without_unit(name) == "sway");
  }
  CHECK(unit_in("deg sway") == Unit::degree);
  CHECK(unit_in("sway deg 2") == std::nullopt);
  CHECK(unit_in("pitch_rate_rads") == std::nullopt);  // radians per second
}

TEST_CASE("columns: a unit with a factor is refused, and declared by the unit option") {
  for (const char* name : {"sway (rad*1e-3)", "sway [1/10 deg]", "sway (deg x10)", "sway_deg_x100", "sway [10^-3 rad]",
                           "sway 10^-3 rad", "sway (0.1 deg)", "sway [deg/10]", "sway (\u00D710 deg)", "sway_urad"}) {
    CAPTURE(std::string(name));
    check_error([&] { find_unit(name, {}, "t", "unit"); }, Code::unit_unknown, name);
    CHECK(find_unit(name, Unit::degree, "t", "unit") == Unit::degree);
  }
  for (const char* name : {"sway_deg", "sway_deg_2", "sway_deg.1", "sway 10 deg", "sway10_deg", "sway [deg]",
                           "trials(2).sway (deg)", "sway (deg) x", "x1_deg", "x10_deg", "sway (deg, 2)"}) {
    CAPTURE(std::string(name));
    CHECK_NOTHROW(find_unit(name, {}, "t", "unit"));
  }
  CHECK(find_metres_per_unit("x (mm)") == 1e-3);
  CHECK(find_metres_per_unit("x10_mm") == 1e-3);  // a marker's name
  CHECK(find_metres_per_unit("x [1/10 mm]") == std::nullopt);
}

TEST_CASE("columns: ROS's times in two columns, whole seconds and nanoseconds, are one time") {
  const auto text = [](const std::string& header) {
    return header + "\n1732876342,990000000,1\n1732876343,0,2\n1732876343,10000000,3\n";
  };
  for (const char* header : {"sec,nanosec,sway_deg", "secs,nsecs,pitch_deg",
                             "header.stamp.sec,header.stamp.nanosec,y_deg", "imu.secs,imu.nsecs,angle_deg"}) {
    CAPTURE(header);
    const Recording recording = read(text(header));
    CHECK(near(recording.rate_hz, 100.0, 1e-4));  // doubles of Unix times have steps of 0.24 us
    REQUIRE(recording.signals.at(com_sway).rad.size() == 3);
    CHECK(recording.signals.at(com_sway).rad[2] == 3.0 * sim::rad_per_deg);
  }
  // Columns of other stems or values are not joined.
  check_error(reading(text("sec,b.nanosec,sway_deg")), Code::times_uneven);
  check_error(reading("sec,nanosec,sway_deg\n1,0,1\n2,2000000000,2\n2,3000000000,3\n"), Code::times_uneven);
  CHECK(nanoseconds_beside({"stamp.sec", "stamp.nanosec"}, 0) == 1);
  CHECK(nanoseconds_beside({"stamp.sec", "other.nanosec"}, 0) == -1);
  CHECK(nanoseconds_beside({"time_s", "nanosec"}, 0) == -1);
}
