// Headers of several rows, each as its program writes it: names, units and rates, and refusals that name the cause.
#include "recording/table/detail/header_rows.hpp"

#include <cmath>
#include <string>

#include "recording/formats/csv.hpp"
#include "tests/recording/table/reading.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

using Names = std::vector<std::string>;

Names names_of(const std::string& text) {
  return CsvTable(text, "t").names();
}

const std::string vicon =
    "Trajectories\n100\n,,S:ANK,,,S:HIP,,\nFrame,Sub Frame,X,Y,Z,X,Y,Z\n,,mm,mm,mm,mm,mm,mm\n"
    "1,0,100,1,2,110,3,4\n2,0,100,1,2,120,3,4\n3,0,100,1,2,130,3,4\n";

}  // namespace

TEST_CASE("Vicon Nexus: markers above axes, units below, the rate below the section's name") {
  CHECK(names_of(vicon) == Names{"Frame", "Sub Frame", "S:ANK X (mm)", "S:ANK Y (mm)", "S:ANK Z (mm)", "S:HIP X (mm)",
                                 "S:HIP Y (mm)", "S:HIP Z (mm)"});
  const Recording recording = read(vicon, {.column = "S:HIP X", .com_height_m = 1.0, .ankle_column = "S:ANK X"});
  CHECK(recording.rate_hz == 100.0);
  CHECK(near(recording.signals.at(com_sway).rad[1], std::asin(0.02), 1e-12));
  // Counters of frames are no candidates, though all others are lengths.
  CHECK(error_of(reading(vicon)).problem() ==
        "has several columns that may be the sway: 'S:ANK X (mm)', 'S:ANK Y (mm)', 'S:ANK Z (mm)', "
        "'S:HIP X (mm)', 'S:HIP Y (mm)', 'S:HIP Z (mm)'");
  // Devices above them: which table is meant is a question, and its end is found.
  const std::string devices =
      "Devices\n1000\n,,Force,,\nFrame,Sub Frame,Fx,Fy,Fz\n,,N,N,N\n1,0,1,2,3\n1,1,1,2,3\n1,2,1,2,3\n\n";
  check_error(reading(devices + vicon), Code::recording_ambiguous, "line 1");
  const Recording second = read(devices + vicon, {.column = "S:HIP X", .skip_lines = 9, .com_height_m = 1.0});
  CHECK(second.rate_hz == 100.0);
  CHECK(CsvTable(devices + vicon, "t", 3).rows(0) == 3);
}

TEST_CASE("Motive: names and kinds above axes, a row of numbers between") {
  const std::string text =
      "Format Version,1.23,Capture Frame Rate,100.000000,Export Frame Rate,100.000000\n\n"
      ",Type,Rigid Body,Rigid Body,Marker\n,Name,Trunk,Trunk,C7\n,ID,1,1,2\n,,Rotation,Position,Position\n"
      "Frame,Time (Seconds),X,X,X\n0,0,1,5,6\n1,0.01,2,5,6\n2,0.02,3,5,6\n";
  CHECK(names_of(text) == Names{"Frame", "Time (Seconds)", "Trunk Rotation X", "Trunk Position X", "C7 Position X"});
  check_one_two_three(text, {.column = "Trunk Rotation X", .unit = Unit::degree});
}

TEST_CASE("Qualisys: names of markers in a line of the preamble") {
  const std::string text =
      "NO_OF_FRAMES\t3\nFREQUENCY\t100\nANALOG_FREQUENCY\t1000\nTIME_STAMP\t2020-03-04, 10:11:12.123\t12345.678\n"
      "MARKER_NAMES\tANK\tHIP\n100\t1\t2\t110\t3\t4\n100\t1\t2\t120\t3\t4\n100\t1\t2\t130\t3\t4\n";
  CHECK(names_of(text) == Names{"ANK X (mm)", "ANK Y (mm)", "ANK Z (mm)", "HIP X (mm)", "HIP Y (mm)", "HIP Z (mm)"});
  CHECK(read(text, {.column = "HIP X", .com_height_m = 1.0}).rate_hz == 100.0);
}

TEST_CASE("Visual3D, Shimmer, LabChart, LabVIEW, AcqKnowledge") {
  CHECK(names_of("\tt.c3d\tt.c3d\n\tCOM\tCOM\n\tORIGINAL\tORIGINAL\nITEM\tX\tY\n1\t1\t2\n2\t1\t2\n3\t1\t2\n") ==
        Names{"ITEM", "COM X", "COM Y"});
  check_one_two_three("\"sep=\t\"\nbelt\tbelt\nTimestamp\tPitch\nCAL\tCAL\nmSecs\tdegrees\n0\t1\n10\t2\n20\t3\n");
  const std::string labchart =
      "Interval=\t0.01 s\nExcelDateTime=\t4.38e+04\t02/01/2020 10:00:00\nTimeFormat=\tStartOfBlock\nDateFormat=\t\n"
      "ChannelTitle=\tSway\tPlatform\nRange=\t10.00 V\t10.00 V\n0\t1\t0\n0.01\t2\t0\n0.02\t3\t0\n";
  CHECK(names_of(labchart) == Names{"time (s)", "Sway", "Platform"});
  check_one_two_three(labchart);
  const auto labview = [](const char* x, const char* rows) {
    return "LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\t" + std::string(x) +
           "\nTime\t10:00:00.123\n***End_of_Header***\t\n\t\nChannels\t2\t\t\nSamples\t3\t3\t\n"
           "X_Dimension\tTime\tTime\t\nX0\t0.0E+0\t0.0E+0\t\nDelta_X\t0.010000\t0.010000\t\n***End_of_Header***\t\t\t\n"
           "X_Value\tSway\tPlatform\tComment\n" +
           rows;
  };
  check_one_two_three(labview("One", "0\t1\t0\t\n0.01\t2\t0\t\n0.02\t3\t0\t\n"));
  check_one_two_three(labview("No", "\t1\t0\t\n\t2\t0\t\n\t3\t0\t\n"));
  std::string with_units = labview("One", "0\t1\t0\t\n0.01\t2\t0\t\n0.02\t3\t0\t\n");
  with_units.insert(with_units.find("X_Dimension"), "Y_Unit_Label\tDegrees\tVolts\t\n");
  CHECK(names_of(with_units) == Names{"time (s)", "Sway (Degrees)", "Platform (Volts)", "Comment"});
  check_one_two_three(with_units, {.column = "Sway"});
  check_error(reading(with_units, {.column = "Platform"}), Code::column_unsuitable);
  const std::string acq =
      "study.acq\n10 msec/sample\n2 channels\nSway\ndeg\nPlatform\ndeg\nmin,CH1,CH2,\n,3,3,\n"
      "0,1,0,\n0.000166666666667,2,0,\n0.000333333333333,3,0,\n";
  CHECK(names_of(acq) == Names{"time (min)", "Sway (deg)", "Platform (deg)"});
  CHECK(near(read(acq).rate_hz, 100.0, 1e-6));
}

TEST_CASE("one row of names is a header as before") {
  CHECK(names_of("Subject,3\ntime,X\n0,1\n0.01,2\n0.02,3\n") == Names{"time", "X"});
  CHECK(names_of("Frequency,100\nx,sway_deg\n0,1\n0,2\n0,3\n") == Names{"x", "sway_deg"});
  CHECK(names_of("lab,3,x\nX,Y,Z\n0,1,1\n0,2,1\n0,3,1\n") == Names{"X", "Y", "Z"});
}

TEST_CASE("a row of units above the names gives the units") {
  const std::string rows = "0,1,0\n0.01,2,0\n0.02,3,0\n";
  const Names names{"time (s)", "CoM (cm)", "platform (deg)"};
  CHECK(names_of("s,cm,deg\ntime,CoM,platform\n" + rows) == names);
  CHECK(names_of("Lab 3\n[s],[cm],[deg]\ntime,CoM,platform\n" + rows) == names);
  CHECK(names_of(",cm,deg\ntime,CoM,platform\n" + rows) == Names{"time", "CoM (cm)", "platform (deg)"});
  check_error(reading("s,cm,deg\ntime,CoM,platform\n" + rows), Code::column_unsuitable, "CoM (cm)");
  check_error(reading("s,inch\ntime,CoM\n0,1\n0.01,2\n0.02,3\n"), Code::column_unsuitable, "CoM (inch)");
  check_one_two_three("ms;Grad\nZeit;X\n0;1\n10;2\n20;3\n");
  // One filled cell is a unit if it is the time's; else it may be a group's name.
  CHECK(names_of("ms,,\ntime,CoM,platform\n" + rows)[0] == "time (ms)");
  for (const char* above : {",m,", ",cm,", ",,deg", ",m"})
    CHECK(names_of(std::string(above) + "\ntime,sway,platform\n" + rows) == Names{"time", "sway", "platform"});
  CHECK(read(",m,\ntime,sway,platform\n" + rows).signals.at(com_sway).column == "sway");
  // Units below count first; a row that is not all units is text above the table.
  CHECK(names_of("s,cm,deg\ntime,CoM,platform\ns,mm,deg\n" + rows)[1] == "CoM (mm)");
  CHECK(names_of("s,cm,Anna\ntime,CoM,platform\n" + rows)[1] == "CoM");
}

TEST_CASE("a row below the names without a time continues them") {
  const std::string rows = "0,1,0\n0.01,2,0\n0.02,3,0\n";
  CHECK(names_of("Time,CoM,Platform\n,AP,\ns,mm,deg\n" + rows) == Names{"Time (s)", "CoM AP (mm)", "Platform (deg)"});
  CHECK(names_of("Time,CoM,\n,AP,ML\n" + rows) == Names{"Time", "CoM AP", "CoM ML"});
  check_error(reading("Time,CoM,Platform\n,AP,\ns,mm,deg\n" + rows), Code::column_unsuitable, "CoM AP (mm)");
  check_one_two_three("Time,Sway,Platform\n,AP,\ns,deg,deg\n" + rows);
}
