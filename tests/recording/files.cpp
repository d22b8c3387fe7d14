// Files as laboratories have them: lines above the table, clock times, and columns found as the sway and the tilt.
#include <cmath>
#include <string>
#include <tuple>

#include "base/text.hpp"
#include "recording/formats/csv.hpp"
#include "recording/table/detail/preamble.hpp"
#include "recording/trial.hpp"
#include "sim/double_pendulum.hpp"
#include "tests/helpers.hpp"
#include "tests/recording/table/reading.hpp"
#include "tests/sim/tiny_protocol.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

TEST_CASE("a line of units is not a header: column names come from the line above") {
  for (const char* units : {"s;Grad;Grad", "[s];[Grad];[Grad]", "sek;deg;", "Sekunden;Grad;Grad"}) {
    const std::string text = "Zeit;KSP;EMG\n" + std::string(units) + "\n0;1;7\n0,01;2;7\n0,02;3;7\n";
    check_one_two_three(text, {.column = "KSP"});
    check_one_two_three(text, {.column = "ksp"});
    check_one_two_three(text);
    CHECK(warning(read(text).warnings, "unit_assumed") == nullptr);
  }
  check_one_two_three("Zeit (Sekunden),KSP [deg]\n0,1\n0.01,2\n0.02,3\n", {.column = "KSP"});
  check_error(reading("time,KSP (deg),KSP [rad]\n0,1,1\n0.01,2,2\n", {.column = "KSP"}), Code::column_ambiguous,
              "'KSP'");
  check_error(reading("Zeit;KSP\n[s;[Grad\n0;1\n"), Code::value_invalid, "line 2");
}

TEST_CASE("lines above the table are passed over, and said so") {
  const std::string table = "time,sway_deg\n0,1\n0.01,2\n0.02,3\n";
  for (const std::string above : {"Subject 12\n", "Subject: A,B,C\nDate: 2026-03-01\n\n", "sep=,\n", "a;b;c;d\ne;f\n",
                                  "# x\nTrial 3, second day, eyes closed\n"}) {
    check_one_two_three(above + table);
    const Recording recording = read(above + table);
    REQUIRE(warning(recording.warnings, "preamble") != nullptr);
    CHECK(warning(recording.warnings, "preamble")->severity == Severity::info);
  }
  CHECK(warning(read(table).warnings, "preamble") == nullptr);
  check_one_two_three("1\n2,3,4\nx\n" + table, {.skip_lines = 3});
  CHECK(warning(read("1\n" + table, {.skip_lines = 1}).warnings, "preamble") == nullptr);
  // These lines give the rate only if there is no column of time.
  check_one_two_three("Frequency: 100 Hz\nx,sway_deg\n0,1\n0,2\n0,3\n");
  check_one_two_three("NO_OF_FRAMES\t3\nDataRate\t100\nx\ty\tsway_deg\n5\t6\t1\n5\t6\t2\n5\t6\t3\n");
  check_one_two_three("Frequency: 200 Hz\n" + table);
  // Units below names, with names above both.
  check_one_two_three("Lab 3\ntime,sway\ns,deg\n0,1\n0.01,2\n0.02,3\n");
  check_one_two_three("note,more\ntime,sway\ns,deg\n0,1\n0.01,2\n0.02,3\n", {.skip_lines = 1});
}

TEST_CASE("a last column that is empty in the first rows takes nothing from the header") {
  check_one_two_three("time,sway_deg,event\n0,1,\n0.01,2,\n0.02,3,\n");
  check_one_two_three("Zeit;sway_deg;Ereignis\n0;1;\n0,01;2;\n0,02;3;los\n");
  CHECK(read("time,sway_rad,note\n0,0.1,\n0.01,0.2,\n0.02,0.3,\n0.03,0.4,x\n").signals.at(com_sway).rad.size() == 4);
  check_error(reading("time,ankle_angle,note\n0,1,\n0.01,2,\n0.02,3,\n"), Code::column_ambiguous,
              "'ankle_angle', 'note'");
  // A last row or two of separators alone, as spreadsheets leave them.
  check_one_two_three("time;sway_deg\n0;1\n0,01;2\n0,02;3\n;\n;\n");
  check_one_two_three("time,sway_deg\n0,1\n0.01,#N/A\n0.02,3\n", {.fill_gaps_s = 0.02});
}

TEST_CASE("lines above a table that look like it, and above one column") {
  const std::string table = "time,sway_deg\n0,1\n0.01,2\n0.02,3\n";
  check_one_two_three("Patient: Schmidt, Anna\nDate: 1 March\n" + table);
  check_one_two_three("Subject,01\nTrial,2\nDay,3\nRate,50\n" + table);
  check_one_two_three("Abtastrate: 100 Hz\nPatient: x\n\nsway_deg\n1\n2\n3\n");
  check_one_two_three("fs=100\nx,sway_deg\n5,1\n5,2\n5,3\n", {.skip_lines = 1});
  check_error(reading("time,sway_deg\n0,x\n0.01,2\n0.02,3\n0.03,4\n"), Code::value_invalid, "line 2, sway_deg");
  check_error(reading("a,sway_deg\none,1\n2,2\n3,3\n4,4\n", {.column = "a", .rate_hz = 100.0}), Code::value_invalid,
              "line 2, a");
  check_error(reading("Patient: Anna\nx\n1,2\n"), Code::table_unclear, "skip_lines");
}

TEST_CASE("units that are no angle's are refused, a column of tilt alone too; minutes are sixty seconds") {
  for (const char* name : {"sway (V)", "sway [N]", "Torque [Nm]", "sway (m/s)", "load (%)"})
    check_error(reading("time," + std::string(name) + "\n0,1\n0.01,2\n"), Code::column_unsuitable, name);
  check_error(reading("time,sway\ns,V\n0,1\n0.01,2\n"), Code::column_unsuitable);
  CHECK(read("time,sway (AP)\n0,1\n0.01,2\n").signals.samples() == 2);  // a note is no unit
  check_error(reading("time,tilt_deg\n0,1\n0.01,2\n"), Code::column_missing, "'s tilt, '");
  CHECK(near(read("time (min),sway_deg\n0,1\n0.01,2\n0.02,3\n").rate_hz, 100.0 / 60.0, 1e-12));
}

TEST_CASE("columns whose names exclude sway are refused, even a single one; parts of the body give a warning") {
  for (const auto& [name, quantity] : {std::pair{"torque_ap", "a torque"},
                                       {"ankle_torque", "a torque"},
                                       {"acc_x", "an acceleration"},
                                       {"EMG_TA", "muscle activity"},
                                       {"ECG", "a heart's signal"},
                                       {"HR", "a heart's signal"},
                                       {"heart_rate", "a heart's signal"},
                                       {"Resp", "breathing"},
                                       {"GSR", "a skin conductance"},
                                       {"GRF", "a force"},
                                       {"gyro_y", "a velocity"},
                                       {"CoP_AP", "a centre of pressure"},
                                       {"COPx (mm)", "a centre of pressure"}})
    check_error(reading("time," + std::string(name) + "\n0,1\n0.01,2\n"), Code::column_unsuitable, quantity);
  const RecordingOptions as_mass{.column = "C7_mm", .com_height_m = 0.9};
  CHECK(warning(read("time,C7_mm\n0,1\n0.01,2\n", as_mass).warnings, "sway_of_a_part") != nullptr);
  check_error(reading("time,COPx_mm\n0,1\n0.01,2\n", {.column = "COPx_mm", .com_height_m = 0.9}),
              Code::column_unsuitable, "COPx_mm");
  for (const char* name : {"head_deg", "trunk_angle_deg", "foot_deg"})
    CHECK(warning(read("time," + std::string(name) + "\n0,1\n0.01,2\n").warnings, "sway_of_a_part") != nullptr);
  CHECK(warning(read("time,lean_deg\n0,1\n0.01,2\n").warnings, "sway_of_a_part") == nullptr);
}

TEST_CASE("a force plate's channels are not sway; the error says what is needed") {
  const std::string pressure = "time,COPx_mm,COPy_mm,", rows = "\n0,1,2,700\n0.01,2,3,701\n0.02,3,4,702\n";
  const auto remedy = [](const std::string& text, const RecordingOptions& options) -> std::string {
    try {
      read(text, options);
    } catch (const Error& error) {
      return error.code() == Code::column_unsuitable ? error.remedy() : "another code";
    }
    return {};
  };
  for (const char* channel : {"Fz", "My", "Force_x", "FP1_Mx", "Fz1"})
    for (const RecordingOptions& options :
         {RecordingOptions{}, {.com_height_m = 0.95}, {.com_height_m = 0.95, .metres_per_unit = 1e-3}}) {
      CAPTURE(std::string(channel));
      check_error(reading(pressure + channel + rows, options), Code::column_unsuitable, "'COPx_mm'");
      CHECK(remedy(pressure + channel + rows, options).starts_with("estimate the centre of mass first"));
    }
  const Error bare = error_of(reading("time,x_mm,Fz" + std::string("\n0,1,700\n0.01,2,701\n"), {.com_height_m = 0.95}));
  CHECK(bare.code() == Code::column_ambiguous);
  CHECK(contains(bare.remedy(), "centre of pressure"));
  // A single channel, and one that is named as a position.
  const std::string load = "time,Fz\n0,700\n0.01,701\n0.02,702\n";
  const RecordingOptions position{.com_height_m = 0.95, .metres_per_unit = 1e-3};
  check_error(reading(load, position), Code::column_unsuitable, "Fz is a force");
  RecordingOptions named = position;
  named.column = "Fz";
  check_error(reading(load, named), Code::column_unsuitable, "Fz is a force");
  CHECK(read("time,Fz,COM_mm\n0,700,1\n0.01,701,2\n0.02,702,3\n", position).signals.at(com_sway).column == "COM_mm");
}

TEST_CASE("with two columns, one of them the platform's tilt, the other is the sway") {
  const Recording recording = read("time,lean_deg,platform_deg\n0,1,0\n0.01,2,0.1\n0.02,3,0.2\n");
  CHECK(recording.signals.at(com_sway).column == "lean_deg");
  CHECK(recording.signals.at(platform_tilt).column == "platform_deg");
  CHECK(read("time,platform_deg,lean_deg\n0,0,1\n0.01,0.1,2\n").signals.at(com_sway).column == "lean_deg");
  check_error(reading("time,lean_deg,other_deg\n0,1,0\n0.01,2,0.1\n"), Code::column_ambiguous);
  // Decimal commas between commas: four cells where two names are.
  check_error(reading("time,lean\n0,01,0,12\n0,02,0,13\n0,03,0,14\n"), Code::table_unclear, "2 names");
}

TEST_CASE("a unit that is not the name's is used, and warned of") {
  const Recording as_given =
      read("time,sway_deg,tilt\n0,.1,1\n0.01,.2,2\n", {.unit = Unit::radian, .tilt_unit = Unit::degree});
  CHECK(as_given.signals.at(com_sway).rad[1] == 0.2);
  const Warning* found = warning(as_given.warnings, "unit_differs");
  REQUIRE(found != nullptr);
  CHECK(found->severity == Severity::caution);
  CHECK(found->text.starts_with("sway_deg has a unit in its name"));
  for (const auto& [name, quantity] : {std::pair{"COP_x", "a centre of pressure"},
                                       {"sway (V)", "a voltage"},
                                       {"sway_mm", "a length"},
                                       {"sway [counts]", "in counts"}}) {
    const Recording other = read("time," + std::string(name) + "\n0,.1\n0.01,.2\n", {.unit = Unit::radian});
    REQUIRE(warning(other.warnings, "unit_differs") != nullptr);
    CHECK(contains(warning(other.warnings, "unit_differs")->text, quantity));
  }
  CHECK(warning(read("time,sway_deg\n0,.1\n0.01,.2\n", {.unit = Unit::degree}).warnings, "unit_differs") == nullptr);
}

TEST_CASE("a header with other names than columns is refused, so that no unit is lost") {
  const std::string rows = "0.00,1.0\n0.01,2.0\n0.02,3.0\n", blanks = "0 1\n0.01 2\n0.02 3\n";
  for (const auto& [header, found] :
       {std::pair{"time,COM_x_cm,note", "3 names between commas"}, std::pair{"COM_x_cm", "1 name"},
        std::pair{"time,COPx,COPy", "3 names"}, std::pair{"time;COM_x_cm", "2 names between semicolons"},
        std::pair{"time\tCOPx", "2 names between tabs"}, std::pair{"time,angular velocity,x", "3 names"},
        std::pair{"time;sway (deg)", "2 names"}, std::pair{"s;cm", "2 names"}, std::pair{"time cop deg", "3 names"},
        std::pair{"COP", "1 name"}, std::pair{"sway_rad,tilt_rad,note", "3 names"}}) {
    const std::string text = header + ("\n" + rows);
    check_error(reading("Lab 3\n\n" + text), Code::table_unclear, found);
    // The error advises this option.
    check_one_two_three("Lab 3\n\n" + text, {.unit = Unit::degree, .skip_lines = 3});
    check_one_two_three(text, {.column = "2", .unit = Unit::degree, .skip_lines = 1});
  }
  check_error(reading("time COM x cm\n" + blanks), Code::table_unclear, "line 1, 'time COM x cm'");
  check_error(reading("Time (s) Sway (cm)\n" + blanks), Code::table_unclear, "4 names");
  for (const char* header : {"\"time\n(s)\",\"COM x\n(cm)\"\n", "\"time\n(s)\",\"CoP\n(deg)\"\n"})
    check_error(reading(header + rows), Code::table_unclear, "line 3, '(");
  for (const char* above :
       {"Subject: time, COM, cm", "fs=100, time, deg", "Trial 3, second day, eyes closed", "Day,1,x", "Anna",
        "Postural sway, subject Anna, first day", "sway of the platform in deg", "Sway angle",
        "time course of the platform's tilt", "height 65\"", "Sex,m,Anna", "Force plate,2,x"}) {
    CAPTURE(above);
    check_one_two_three(std::string(above) + "\n" + rows);
  }
}

TEST_CASE("a damaged row is not taken for a line above the table") {
  check_error(reading("time,sway\n0,1,1\n0.01,2\n0.02,3\n0.03,4\n"), Code::table_unclear, "line 2");
  check_error(reading("0,1,1\n0.01,2\n0.02,3\n0.03,4\n"), Code::table_unclear, "line 2");
  check_error(reading("1,2,3\ntime,sway\n0,1\n0.01,2\n0.02,3\n"), Code::table_unclear);
  CHECK(find_preamble("").lines == 0);
  CHECK(find_preamble("a\nb\nc\n").lines == 0);
  CHECK(find_preamble("sway\nx\n1\n2\n3\n").lines == 0);  // one column: which line is its name?
}

TEST_CASE("tables of OpenSim: .mot with its end of header, .trc with names in two lines and a unit") {
  check_one_two_three(
      "Coordinates\nversion=1\nnRows=3\nnColumns=2\ninDegrees=yes\nendheader\ntime\tsway_deg\n0\t1\n0.01\t2\n0."
      "02\t3\n");
  const std::string radians =
      "Coordinates\ninDegrees = no\nendheader\ntime\tsway\ttilt_deg\n0\t.1\t1\n.01\t.2\t2\n.02\t.3\t3\n";
  for (const std::optional<int> skip : {std::optional<int>(), std::optional<int>(3)}) {
    const Recording stated = read(radians, {.tilt_column = "tilt_deg", .skip_lines = skip});
    CHECK(stated.signals.at(com_sway).rad == std::vector<double>{0.1, 0.2, 0.3});
    CHECK(stated.signals.at(platform_tilt).rad[0] == sim::rad_per_deg);  // by its name
    CHECK(warning(stated.warnings, "unit_assumed") == nullptr);
    CHECK(warning(stated.warnings, "unit_differs") == nullptr);
  }
  const std::string trc =
      "PathFileType\t4\t(X/Y/Z)\tt.trc\n"
      "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\n100\t100\t3\t2\tmm\n"
      "Frame#\tTime\tHIP\t\t\tC7\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n"
      "1\t0.00\t10\t900\t1\t0\t1400\t2\n2\t0.01\t20\t900\t1\t0\t1400\t2\n3\t0.02\t30\t900\t1\t0\t1400\t2\n";
  const CsvTable table(trc, "t.trc");
  CHECK(table.names() == std::vector<std::string>{"Frame#", "Time", "HIP X (mm)", "HIP Y (mm)", "HIP Z (mm)",
                                                  "C7 X (mm)", "C7 Y (mm)", "C7 Z (mm)"});
  CHECK(table.rows(0) == 3);
  CHECK(table.numbers(2) == std::vector<double>{10, 20, 30});
  CHECK(table.locate(0) == "line 7");
  const Recording recording = read(trc, {.column = "HIP X", .com_height_m = 0.9});
  CHECK(recording.rate_hz == 100.0);
  CHECK(near(recording.signals.at(com_sway).rad[2], std::asin(0.01 / 0.9), 1e-15));  // from the mean, 20 mm
  check_error(reading("PathFileType\t4\n"), Code::file_empty);
  // Fewer figures than names, an invalid rate, coordinates without a marker and a marker without a coordinate.
  const CsvTable sparse(
      "PathFileType\t4\nDataRate\tUnits\tFrames\n0\tmm\nFrame#\tTime\tHIP\t\tC7\n\t\tX1\tY1\n"
      "1\t0\t10\t900\t7\n2\t0.5\t20\t900\t7\n",
      "t.trc");
  CHECK(sparse.names() == std::vector<std::string>{"Frame#", "Time", "HIP X (mm)", "HIP Y (mm)", "C7"});
  CHECK(sparse.stated_rates().empty());
  // A long name above many coordinates would stand in each column's.
  std::string coordinates = "\t\tX1";
  for (int i = 0; i < 40'000; ++i) coordinates += "\tY1";
  check_error(reading("PathFileType\t4\nDataRate\tUnits\n100\tmm\nFrame#\tTime\t" + std::string(100'000, 'm') + "\n" +
                      coordinates + "\n1\t0\t1\n"),
              Code::file_too_large, "1001 columns");
}

TEST_CASE("a negative number of lines above the table is refused") {
  const TemporaryFolder folder;
  const auto path = write_text(folder / "r.csv", "time,sway_deg\n0,1\n0.01,2\n0.02,3\n");
  for (const int lines : {-1, -7})
    check_error([&] { read_recording(path, {.skip_lines = lines}); }, Code::setting_out_of_range, "skip_lines");
}

TEST_CASE("only times without a date pass midnight: those with one go back") {
  const auto times = [](const std::string& before, const std::string& after) {
    return CsvTable("time,x\n" + before + ",1\n" + after + ",2\n", "r.csv").times(0);
  };
  CHECK(times("23:59:59.5", "00:00:00.5") == std::vector<double>{86399.5, 86400.5});
  CHECK(times("2026-03-05 23:59:59.5", "2026-03-06 00:00:00.5") == std::vector<double>{86399.5, 86400.5});
  CHECK(times("2026-03-05 23:59:59.5", "2026-03-05 00:00:00.5") == std::vector<double>{86399.5, 0.5});
}

TEST_CASE("clock times are times, over midnight too") {
  for (const auto& [a, b, c] : {std::tuple{"12:00:00,00", "12:00:00,01", "12:00:00,02"},
                                {"2026-03-05 23:59:59.99", "2026-03-06 00:00:00.00", "2026-03-06 00:00:00.01"},
                                {"23:59:59.99", "00:00:00.00", "00:00:00.01"},
                                {"1:00:00.00 PM", "1:00:00.01 PM", "1:00:00.02 PM"},
                                {"0 days 00:00:00.00", "0 days 00:00:00.01", "0 days 00:00:00.02"},
                                {"00:59.99", "01:00.00", "01:00.01"},
                                {"0 sec", "0.01 sec", "0.02 sec"}})
    check_one_two_three(std::string("Uhrzeit;sway_deg\n") + a + ";1\n" + b + ";2\n" + c + ";3\n");
  check_one_two_three("23:59:59.99,1\n00:00:00.00,2\n00:00:00.01,3\n", {.column = "2", .unit = Unit::degree});
  check_error(reading("time,sway_deg\n12:00:00.00,1\n12:61:00,2\n"), Code::value_invalid, "line 3, time");
  check_error(reading("time,sway_deg\n0,12:00:00\n0.01,2\n0.02,3\n"), Code::value_invalid, "line 2, sway_deg");
}

TEST_CASE("names of joints and parts are known between capitals and behind the letter of a side") {
  const auto text = [](const std::string& name) { return "time," + name + "\n0,1\n0.01,2\n"; };
  for (const char* name : {"LAnkleAngles", "AbsAnkleAngle", "AnkleAngle_deg", "RANKLE_deg", "leftAnkleFlexion_deg",
                           "Sprunggelenkwinkel_Grad", "Sprunggelenk [Grad]"})
    check_error(reading(text(name)), Code::column_unsuitable, name);
  check_error(reading(text("ankle_deg"), {.column = "ankle_deg", .unit = Unit::degree}), Code::column_unsuitable);
  check_error(reading("frequency_hz,gain,phase_deg\n0.1,1,0\n0.2,1,-10\n"), Code::file_unsupported);
  for (const char* name : {"RKneeAngles", "RPelvisAngles", "LThoraxAngles", "HeadAngles", "SpineAngles_deg",
                           "LHipAngles_deg", "rknee_deg", "C7_x", "C7 X", "C7.AP", "swayC7_deg", "RSHO_x",
                           "LShoulder X", "ACROMION_x", "Sternum_deg", "STRN_x", "CLAV_x", "chest_deg", "T10_x"}) {
    CAPTURE(std::string(name));
    CHECK(warning(read(text(name)).warnings, "sway_of_a_part") != nullptr);
  }
  for (const char* name : {"CoMAngle", "CoMAnkleAngle_deg", "comAngle", "BodySway", "hip_sway_deg", "SC7_deg",
                           "C70_deg", "shown_deg", "AT10_deg", "sacrum_x", "L3_x"}) {
    CAPTURE(std::string(name));
    CHECK(warning(read(text(name)).warnings, "sway_of_a_part") == nullptr);
  }
}

TEST_CASE("other directions, gazes and targets are not forward sway") {
  const auto text = [](const std::string& name) { return "time," + name + "\n0,1\n0.01,2\n"; };
  for (const char* name :
       {"COM_ML", "sway_ML_deg", "sway (ML)", "sway_lateral_deg", "yaw", "gaze", "target", "swayYaw", "HeadingDeg"}) {
    CAPTURE(std::string(name));
    const Recording recording = read(text(name));
    REQUIRE(warning(recording.warnings, "not_this_sway") != nullptr);
    CHECK(warning(recording.warnings, "not_this_sway")->severity == Severity::caution);
  }
  for (const char* name : {"sway_AP_deg", "pitch", "com_sway", "roll"})
    CHECK(warning(read(text(name)).warnings, "not_this_sway") == nullptr);
}

TEST_CASE("a column that is plainly the platform's tilt is used, and left out if it does not follow the protocol") {
  const sim::Protocol protocol = tiny_protocol();
  const auto text = [&](const char* name, double gain, int delay) {
    const sim::Stimulus stimulus = sim::make_stimulus(protocol.experiment);
    std::string rows = "time,sway_deg," + std::string(name) + "\n";
    char row[96];
    for (int k = 0; k < protocol.samples() + delay; ++k) {
      const int at = std::max(0, k - delay) * protocol.experiment.steps_per_sample();
      std::snprintf(row, sizeof row, "%.2f,%.6f,%.6f\n", k / 100.0, std::sin(0.1 * k),
                    gain * stimulus.tilt_at(at) / sim::rad_per_deg);
      rows += row;
    }
    return rows;
  };
  for (const char* name : {"tilt_deg", "platform (deg)", "Plattform [Grad]", "platform"}) {
    CAPTURE(name);
    Recording recording = read(text(name, 1.0, 30));
    const Trial trial = bring_to_protocol(recording, protocol);
    REQUIRE(trial.tilt);
    CHECK(near(trial.tilt->delay_s, 0.3, 0.02));
    REQUIRE(warning(recording.warnings, "tilt_found") != nullptr);
    CHECK(worst_trust({*warning(recording.warnings, "tilt_found")}) == Trust::usable);
  }
  // With the other sign the recording is unusable, unless the column is not a tilt.
  Recording reversed = read(text("platform_deg", -1.0, 0));
  CHECK_FALSE(bring_to_protocol(reversed, protocol).tilt);
  REQUIRE(warning(reversed.warnings, "tilt_not_used") != nullptr);
  CHECK(warning(reversed.warnings, "tilt_not_used")->severity == Severity::invalid);
  Recording without = read(text("platform_deg", -1.0, 0), {.find_tilt = false});
  CHECK(without.signals.find(platform_tilt) == nullptr);
  CHECK_FALSE(bring_to_protocol(without, protocol).tilt);
  CHECK(worst_trust(without.warnings) != Trust::not_usable);
  // Its sign can be reversed as for a named column; without a tilt this is an error.
  Recording turned = read(text("platform_deg", -1.0, 0), {.invert_tilt = true});
  CHECK(bring_to_protocol(turned, protocol).tilt.has_value());
  check_error(reading("time,sway_deg\n0,1\n0.01,2\n", {.invert_tilt = true}), Code::setting_missing, "tilt_column");
  // A column that is not an angle is not taken for the tilt.
  const Recording length = read("time,sway_deg,platform_mm\n0,1,1\n0.01,2,1\n");
  CHECK(length.signals.find(platform_tilt) == nullptr);
  CHECK(warning(length.warnings, "tilt_not_used") != nullptr);
}

TEST_CASE("without a sway column the columns that are another quantity are named") {
  for (const std::string name : {"CoM (inches)", "Schwerpunkt x mm", "CoM (% height)", "sway [V]", "sway [deg/s]"}) {
    CAPTURE(name);
    check_error(reading("time," + name + ",platform\n0,1,1\n0.01,2,2\n0.02,3,3\n"), Code::column_missing,
                "'" + name + "' is a");
  }
}
