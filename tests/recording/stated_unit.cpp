// Units in words above a table: phrases that state one, the columns that get it, and files that are then refused.
#include "recording/detail/stated_unit.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "tests/recording/table/reading.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

std::vector<std::string> with_units(const std::string& lines, std::vector<std::string> names) {
  std::vector<StatedUnit> units;
  std::string line;
  for (const char c : lines + "\n")
    if (c == '\n') {
      add_stated_unit(line, units);
      line.clear();
    } else {
      line += c;
    }
  add_units(units, names);
  return names;
}

using Names = std::vector<std::string>;

}  // namespace

TEST_CASE("a unit for the whole file is that of columns without one") {
  for (const char* line : {"Units,cm", "Units: cm", "# unit = cm", "Einheit;cm", "Name,s01,Unit,cm,Site,Graz"})
    CHECK(with_units(line, {"time", "frame", "COM_x", "angle_deg", "Fz (N)"}) ==
          Names{"time", "frame", "COM_x (cm)", "angle_deg", "Fz (N)"});
  CHECK(with_units("Units: rad", {"t", "sway"}) == Names{"t", "sway (rad)"});
  for (const char* line : {"Units,SI", "Units", "Units,s,deg", "Unit cells,cm", "United,cm", "Units: 5"})
    CHECK(with_units(line, {"t", "sway"}) == Names{"t", "sway"});
  CHECK(with_units("Units: mm\nUnits: deg", {"t", "sway"}) == Names{"t", "sway"});
  CHECK(with_units("Units: mm\nUnits: mm", {"t", "sway"}) == Names{"t", "sway (mm)"});
}

TEST_CASE("a unit of lengths is that of coordinates") {
  const std::string line = "Format Version,1.23,Export Frame Rate,100,Length Units,Centimeters,Coordinate Space,Global";
  CHECK(
      with_units(line, {"Frame", "Time (Seconds)", "COM Position X", "Z", "Trunk Rotation X", "sway"}) ==
      Names{"Frame", "Time (Seconds)", "COM Position X (Centimeters)", "Z (Centimeters)", "Trunk Rotation X", "sway"});
}

TEST_CASE("NDI's markers are positions, its counts are not") {
  for (const char* line : {"Units:\tmm", "Data units: mm", "Distance units: mm"})
    CHECK(with_units(line, {"Frame", "Item", "Marker", "Marker_1 x", "Marker_1 z"}) ==
          Names{"Frame", "Item", "Marker", "Marker_1 x (mm)", "Marker_1 z (mm)"});
  const std::string file =
      "Number of Frames:\t4\nFrequency (Hz):\t100\nUnits:\tmm\n\nFrame\tMarker_1 x\tMarker_1 y\n"
      "1\t0\t900\n2\t100\t900\n3\t-100\t900\n4\t0\t900\n";
  check_error(reading(file, {.column = "Marker_1 x"}), Code::column_unsuitable, "mm");
  const Recording recording = read(file, {.column = "Marker_1 x", .com_height_m = 1.0});
  CHECK(near(recording.signals.at(com_sway).rad[1], std::asin(0.1), 1e-12));
}

TEST_CASE("stated units decide how a file is read") {
  const std::string rows = "0,0.01\n0.01,0.02\n0.02,0.03\n";
  CHECK(near(read("Units: rad\ntime,sway\n" + rows).signals.at(com_sway).rad[1], 0.02, 1e-12));
  CHECK(near(read("# unit: rad\ntime,sway\n" + rows).signals.at(com_sway).rad[1], 0.02, 1e-12));
  for (const char* above : {"Units,cm\ntime,sway\n", "# units: mm\ntime,sway\n", "# units: mV\ntime,sway\n",
                            "a,1,Length Units,Meters,b,2\ntime,X\n"})
    check_error(reading(above + rows), Code::column_unsuitable);
  // Motive's lengths in metres, above the ankles.
  const Recording recording =
      read("a,1,Length Units,Meters,b,2\ntime,X\n0,0\n0.01,0.1\n0.02,-0.1\n", {.com_height_m = 1.0});
  CHECK(near(recording.signals.at(com_sway).rad[1], std::asin(0.1), 1e-12));
  const std::string labchart =
      "Interval=\t0.01 s\nTimeFormat=\tStartOfBlock\nChannelTitle=\tSway\tTilt\nRange=\t10.000 V\t10.000 "
      "V\nUnitName=\t";
  const std::string samples = "0\t1\t0\n0.01\t2\t0\n0.02\t3\t0\n";
  check_one_two_three(labchart + "deg\tdeg\n" + samples);
  check_error(reading(labchart + "V\tV\n" + samples), Code::column_unsuitable);
  CHECK(near(read(labchart + "rad\t*\n0\t0.1\t0\n0.01\t0.2\t0\n").signals.at(com_sway).rad[1], 0.2, 1e-12));
}

TEST_CASE("voltages and fractions of the body's height are no angles") {
  for (const char* name : {"sway_V", "sway (%BH)", "sway [%height]"})
    check_error(reading(std::string("time,") + name + "\n0,1\n0.01,2\n0.02,3\n"), Code::column_unsuitable);
  check_error(reading("time,a (V),b (mV)\n0,1,2\n0.01,2,2\n0.02,3,2\n"), Code::column_unsuitable);
  check_error(reading("time,a (V),b\n0,1,2\n0.01,2,2\n0.02,3,2\n", {.column = "a (V)"}), Code::column_unsuitable);
  check_one_two_three("time,a (V),b\n0,2,1\n0.01,2,2\n0.02,2,3\n");
  // A gyroscope's signal is a velocity, unless its name says that it is integrated.
  check_one_two_three("time,EMG 1 [V],Gyro angle [deg]\n0,2,1\n0.01,2,2\n0.02,2,3\n");
  check_error(reading("time,Gyro angle\n0,1\n0.01,2\n"), Code::column_unsuitable);
}
