// Sway made from positions, markers and segments, and names of columns that may be lengths.
#include <cmath>
#include <set>
#include <string>

#include "base/math/random.hpp"
#include "base/text.hpp"
#include "recording/trial.hpp"
#include "sim/double_pendulum.hpp"
#include "tests/helpers.hpp"
#include "tests/recording/default_protocol.hpp"
#include "tests/recording/table/reading.hpp"
#include "tests/sim/tiny_protocol.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

TEST_CASE("positions are sway at their height above the ankles") {
  const auto sway = [](const std::string& text, const RecordingOptions& options) {
    return read(text, options).signals.at(com_sway).rad;
  };
  const std::string text = "time,COM_x_mm,ankle_mm\n0,100,100\n0.01,110,100\n0.02,140,110\n";
  const auto from_ankle = sway(text, {.column = "COM_x_mm", .com_height_m = 0.95, .ankle_column = "ankle_mm"});
  CHECK(from_ankle[0] == 0.0);
  CHECK(near(from_ankle[1], std::asin(0.01 / 0.95), 1e-14));
  CHECK(near(from_ankle[2], std::asin(0.03 / 0.95), 1e-14));
  // Without the ankle their mean is upright, said so.
  const Recording centred = read("time,COM_x_cm\n0,1\n0.01,2\n0.02,3\n", {.com_height_m = 1.0});
  CHECK(near(centred.signals.at(com_sway).rad[0], -std::asin(0.01), 1e-14));
  CHECK(warning(centred.warnings, "mean_is_upright") != nullptr);
  CHECK(near(sway("time,x\n0,1\n0.01,2\n0.02,3\n", {.com_height_m = 1.0, .metres_per_unit = 1e-3})[2], std::asin(1e-3),
             1e-14));
  check_error(reading(text), Code::column_unsuitable, "COM_x_mm");
  check_error(reading("time,x\n0,1\n0.01,2\n", {.com_height_m = 1.0}), Code::unit_unknown);
  check_error(reading("time,x_m\n0,1\n0.01,4\n", {.com_height_m = 1.0}), Code::value_invalid);
  check_error(reading("time,sway_deg\n0,1\n0.01,4\n", {.ankle_column = "time"}), Code::setting_missing, "com_height");
  check_error(reading("time,sway\n0,1\n0.01,4\n", {.metres_per_unit = 1.0}), Code::setting_missing, "com_height");
  check_error(reading("time,sway_deg\n0,1\n0.01,4\n", {.metres_per_unit = 1e-3}), Code::setting_missing,
              "unit mm declares sway_deg a length");
  // A unit of angles for positions, and a unit of lengths for angles.
  for (const Unit angle : {Unit::degree, Unit::radian, Unit::milliradian}) {
    check_error(reading(text, {.column = "COM_x_mm", .unit = angle, .com_height_m = 0.95}), Code::setting_conflict,
                "unit");
    check_error(
        reading("time,hip_mm,shoulder_mm\n0,1,2\n0.01,2,4\n",
                {.unit = angle, .hip_column = "hip_mm", .shoulder_column = "shoulder_mm", .body_height_m = 1.7}),
        Code::setting_conflict, "unit");
  }
  check_error(reading("time,leg,trunk\n0,1,2\n0.01,2,4\n",
                      {.leg_column = "leg", .trunk_column = "trunk", .metres_per_unit = 1e-3}),
              Code::setting_conflict, "unit");
  for (const double wrong : {-1.0, 0.0, std::nan(""), static_cast<double>(INFINITY)}) {
    check_error(reading(text, {.com_height_m = wrong}), Code::setting_out_of_range, "com_height");
    check_error(reading(text, {.body_height_m = wrong}), Code::setting_out_of_range, "height");
  }
}

TEST_CASE("impossible values of a unit that contradicts the name's are refused with both units") {
  const std::string text = "time,COM_x (mm)\n0,140\n0.01,152\n0.02,146\n", far = "time,COM_x (mm)\n0,1\n0.01,1999\n";
  check_error(reading(text, {.unit = Unit::degree}), Code::value_invalid, "not an angle");
  check_error(reading(far, {.com_height_m = 0.95, .metres_per_unit = 1e-2}), Code::value_invalid, "in its name");
  // Without a contradiction the values themselves are.
  const std::string of_far = error_of(reading(far, {.com_height_m = 0.95, .metres_per_unit = 1e-3})).what();
  CHECK(contains(of_far, "ankle"));
  CHECK_FALSE(contains(of_far, "in its name"));
  CHECK_FALSE(contains(error_of(reading("time,sway\n0,140\n0.01,152\n0.02,146\n")).what(), "in its name"));
}

TEST_CASE("with a height of the centre of mass, lengths are the candidates, and its other names are known") {
  const auto column_of = [](const std::string& names, std::optional<double> metres = {}) {
    return read("time," + names + "\n0,1,5\n0.01,2,3\n0.02,3,7\n", {.com_height_m = 0.95, .metres_per_unit = metres})
        .signals.at(com_sway)
        .column;
  };
  for (const std::string name : {"KSP_x_mm", "CentreOfMass_X_mm", "CenterOfMass_X_mm", "Sub1:COM_X_mm",
                                 "CentreOfMass X (mm)", "Sub1:Centre_of_mass AP (cm)", "waist_mm"}) {
    CAPTURE(name);
    CHECK(column_of(name + ",Kanal2") == name);
    CHECK(column_of("trunk_angle_deg," + name) == name);
    CHECK(column_of(name + ",sway_deg") == name);
  }
  CHECK(column_of("LASI_x_mm,KSP_x_mm") == "KSP_x_mm");
  for (const std::string name : {"sway_mm", "COM_x_mm"})
    CHECK(warning(read("time," + name + ",waist_mm\n0,1,5\n0.01,2,3\n", {.com_height_m = 0.95}).warnings,
                  "column_assumed") == nullptr);
  CHECK(column_of("sway,KSP_x_mm") == "KSP_x_mm");
  // A sway without a unit may be the length, and a given unit is its own.
  check_error([&] { column_of("COM_x,LASI_x_mm"); }, Code::unit_unknown);
  CHECK(column_of("COM_x,KSP_x_mm", 1e-3) == "COM_x");
  check_error([&] { column_of("Sub1:COM_X_mm,Sub2:COM_X_mm"); }, Code::column_ambiguous, "Sub2:COM_X_mm");
  check_error([&] { column_of("LASI_x_mm,RASI_x_mm"); }, Code::column_ambiguous);
}

TEST_CASE("leg and trunk, or hip and shoulder, make the sway of the centre of mass") {
  const sim::Segments segments = sim::make_segments({.mass_kg = 70.0, .height_m = 1.7});
  const sim::DoubleBody body(segments);
  const double leg = 1.0 * sim::rad_per_deg, trunk = -2.0 * sim::rad_per_deg;
  const Recording angles =
      read("time,leg_deg,trunk_deg\n0,0,0\n0.01,1,-2\n0.02,1,1\n", {.leg_column = "leg_deg", .trunk_column = "3"});
  const auto& sway = angles.signals.at(com_sway).rad;
  CHECK(sway[0] == 0.0);
  CHECK(near(sway[1], body.centre_of_mass(leg, trunk), 1e-14));
  CHECK(near(sway[2], leg, 1e-14));  // a straight body
  CHECK(angles.signals.at(com_sway).column == "leg_deg, trunk_deg");
  // Markers on the same segments.
  char row[128];
  std::string text = "time,hip_m,shoulder_m,ankle_m\n0,0.1,0.1,0.1\n";
  const double hip = segments.leg_length_m * std::sin(leg), shoulder = hip + segments.trunk_length_m * std::sin(trunk);
  std::snprintf(row, sizeof row, "0.01,%.15f,%.15f,0.1\n", 0.1 + hip, 0.1 + shoulder);
  text += row;
  const RecordingOptions markers{
      .hip_column = "hip_m", .shoulder_column = "shoulder_m", .ankle_column = "ankle_m", .body_height_m = 1.7};
  CHECK(near(read(text, markers).signals.at(com_sway).rad[1], body.centre_of_mass(leg, trunk), 1e-13));
  RecordingOptions without_height = markers;
  without_height.body_height_m = {};
  check_error(reading(text, without_height), Code::setting_missing);
  check_error(reading(text, {.hip_column = "hip_m"}), Code::setting_missing);
  check_error(reading(text, {.leg_column = "hip_m"}), Code::setting_missing);
  check_error(reading(text, {.column = "2", .leg_column = "2", .trunk_column = "3"}), Code::setting_conflict);
  check_error(reading(text, {.leg_column = "2", .trunk_column = "2"}), Code::setting_conflict, "hip_m");
  RecordingOptions same = markers;
  same.shoulder_column = "hip_m";
  check_error(reading(text, same), Code::setting_conflict, "hip_m");
  const auto codes = [&](const RecordingOptions& options, const std::string& names) {
    std::set<std::string> found;
    const std::string table = names + text.substr(text.find('\n')) + "0.02,0.11,0.13,0.1\n";
    for (const Warning& warning : read(table, options).warnings) found.insert(warning.code);
    return found;
  };
  CHECK_FALSE(codes(markers, "time,hip_m,shoulder_m,ankle_m").contains("shoulder_moves_less"));
  CHECK_FALSE(codes(markers, "time,hip_m,shoulder_m,ankle_m").contains("axes_differ"));
  CHECK(codes({.hip_column = "3", .shoulder_column = "2", .ankle_column = "4", .body_height_m = 1.7},
              "time,hip_m,shoulder_m,ankle_m")
            .contains("shoulder_moves_less"));
  const RecordingOptions by_number{
      .hip_column = "2", .shoulder_column = "3", .ankle_column = "4", .body_height_m = 1.7};
  CHECK(codes(by_number, "time,HIP_x (m),C7 Z (m),ANK.x (m)").contains("axes_differ"));
  CHECK(codes(by_number, "time,HIP_x (m),C7 X (m),ANK_y_m").contains("axes_differ"));
  CHECK_FALSE(codes(by_number, "time,HIP_x (m),C7 X (m),ANK.x_m").contains("axes_differ"));
  check_error(reading(text, {.leg_column = "2", .trunk_column = "no"}), Code::column_missing, "'no'");
}

TEST_CASE("a hip that moves is warned of, two sensors of one segment are not") {
  // Leg and trunk of 1 degree; the trunk also has another share of it, a drift, an offset, and both have noise.
  const auto warned = [](double share) {
    std::string text = "time,leg_deg,trunk_deg\n";
    const Random random(3, Stream::user, 0);
    for (int k = 0; k < 4800; ++k) {
      const double sway = sin(0.01 * k), drift = 0.3 + 1e-4 * k;
      text += format("%.2f,%.5f,%.5f\n", 0.01 * k, sway + 0.02 * random.normal(2 * static_cast<std::uint64_t>(k)),
                     (1.0 + share) * sway + drift + 0.02 * random.normal(2 * static_cast<std::uint64_t>(k) + 1));
    }
    for (const Warning& warning : read(text, {.leg_column = "leg_deg", .trunk_column = "trunk_deg"}).warnings)
      if (warning.code == "hip_moves") return true;
    return false;
  };
  CHECK_FALSE(warned(0.0));
  CHECK_FALSE(warned(0.1));
  CHECK(warned(0.4));
  CHECK(warned(-0.4));
}

namespace {

/// Returns whether hip_moves warns of a table: a sway in degrees at 100 Hz, then two columns that cells() writes.
template <class Cells>
bool hip_warned(const std::vector<double>& sway_deg, const std::string& header, const Cells& cells,
                const RecordingOptions& options = {}) {
  std::string text = "time," + header + "\n";
  for (std::size_t k = 0; k < sway_deg.size(); ++k)
    text += format("%.2f,%.6f,", 0.01 * static_cast<double>(k), sway_deg[k]) + cells(k) + "\n";
  return warning(read(text, options).warnings, "hip_moves") != nullptr;
}

}  // namespace

TEST_CASE("a hip that moves is warned of where columns of leg and trunk stand beside the sway: 12 of 12, 0 of 60") {
  const std::string names = "com_sway_deg,leg_deg,trunk_deg";
  sim::Protocol protocol = sim::default_protocol();
  const sim::DoubleSimulator of_two(protocol);
  const auto n = static_cast<std::size_t>(of_two.samples());
  std::vector<double> com(n), leg(n), trunk(n);
  const auto in_degrees = [](std::vector<double> values) {
    for (double& value : values) value /= sim::rad_per_deg;
    return values;
  };
  int of_two_segments = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    REQUIRE(
        of_two.run(sim::default_double_parameters(of_two.segments()), Random(seed, Stream::user, 0), {com, leg, trunk})
            .valid);
    const std::vector<double> leg_deg = in_degrees(leg), trunk_deg = in_degrees(trunk);
    of_two_segments += hip_warned(in_degrees(com), names,
                                  [&](std::size_t k) { return format("%.6f,%.6f", leg_deg[k], trunk_deg[k]); });
  }
  CHECK(of_two_segments == 12);
  int of_one_segment = 0;
  for (std::uint64_t i = 0; i < 60; ++i) {
    const std::vector<double> sway_deg = in_degrees(trial_of_prior(7, i, [](sim::Parameters&) {}));
    const Random random(8, Stream::user, i);
    of_one_segment += hip_warned(sway_deg, names, [&](std::size_t k) {
      return format("%.6f,%.6f", sway_deg[k] + 0.02 * random.normal(2 * k),
                    sway_deg[k] + 0.02 * random.normal(2 * k + 1));
    });
  }
  CHECK(of_one_segment == 0);

  const std::vector<double> sway_deg = in_degrees(com), leg_deg = in_degrees(leg), trunk_deg = in_degrees(trunk);
  const auto warned = [&](const std::string& header, const auto& cells) { return hip_warned(sway_deg, header, cells); };
  const auto both = [&](std::size_t k) { return format("%.6f,%.6f", leg_deg[k], trunk_deg[k]); };
  const auto in_rad = [&](std::size_t k) {
    return format("%.8f,%.8f", leg_deg[k] * sim::rad_per_deg, trunk_deg[k] * sim::rad_per_deg);
  };
  CHECK(warned("com_sway_deg,Leg,Trunk", both));
  CHECK(warned("com_sway_deg,leg_rad,trunk_rad", in_rad));
  CHECK(hip_warned(sway_deg, "x_deg,leg_deg,trunk_deg", both, {.column = "x_deg"}));
  CHECK(hip_warned(sway_deg, names, both, {.column = "com_sway_deg", .invert_sway = true}));
  CHECK(warned("com_sway_deg,leg_deg,trunk_rad",
               [&](std::size_t k) { return format("%.6f,%.8f", leg_deg[k], trunk_deg[k] * sim::rad_per_deg); }));
  const auto wrapped = [](double deg) { return deg < 0.0 ? deg + 360.0 : deg; };
  CHECK(warned(names, [&](std::size_t k) {
    return (k % 500 == 7 ? "" : format("%.6f", wrapped(leg_deg[k]))) + format(",%.6f", wrapped(trunk_deg[k]));
  }));
  // Deviations are compared over the samples that all three have.
  std::vector<double> larger_deg = sway_deg;
  for (std::size_t k = 0; k < n / 4; ++k) larger_deg[k] += 20.0 * std::sin(0.005 * static_cast<double>(k));
  CHECK(hip_warned(larger_deg, names, [&](std::size_t k) { return k < n / 4 ? "," : both(k); }));
  // One sample in 50 is missing, so every block lacks some.
  CHECK(warned(names, [&](std::size_t k) { return k % 50 == 7 ? "," : both(k); }));
  // Columns whose names have no unit have the sway's.
  CHECK(hip_warned(com, "com_sway_rad,leg,trunk", in_rad));
  // A length is not compared, even if its numbers would fit as degrees; nor is a column of another name, as leg_V is.
  for (const char* header :
       {"com_sway_deg,leg_mm,trunk_mm", "com_sway_deg,leg_V,trunk_V", "com_sway_deg,leg_deg,trunk_V",
        "com_sway_deg,leg_mm,trunk_deg", "com_sway_deg,knee_deg,trunk_deg"}) {
    CAPTURE(std::string(header));
    CHECK_FALSE(warned(header, both));
  }
  // Numbers of another unit than the names say, and other angles, do not fit the sway.
  for (const char* header : {"com_sway_deg,leg_rad,trunk_rad", "com_sway_deg,leg_deg,trunk_rad"}) {
    CAPTURE(std::string(header));
    CHECK_FALSE(warned(header, both));
  }
  CHECK_FALSE(hip_warned(sway_deg, "com_sway_deg,leg_deg,leg_deg", both, {.column = "com_sway_deg"}));
  CHECK_FALSE(warned(names, [&](std::size_t k) { return format("%.6f,%.6f", leg_deg[k], trunk_deg[k] - leg_deg[k]); }));
  CHECK_FALSE(warned(names, [&](std::size_t k) { return format("1,%.6f", trunk_deg[k]); }));
  CHECK_FALSE(warned(names, [&](std::size_t k) { return format("%.6f,0", leg_deg[k]); }));
  CHECK_FALSE(warned(names, [](std::size_t) { return "1,1"; }));
  CHECK_FALSE(warned(names, [&](std::size_t k) { return format("%.6f,", leg_deg[k]); }));
  CHECK_FALSE(warned(names, [&](std::size_t k) { return format("%.6f,", leg_deg[k]) + (k == 7 ? "bad" : "1"); }));
}

TEST_CASE("positions without a unit are read as degrees with a caution, angles without one") {
  const auto text = [](const std::string& name) { return "time," + name + "\n0,1\n0.01,2\n"; };
  for (const std::string name : {"COM_x",
                                 "CoM X",
                                 "COMx",
                                 "COG_y",
                                 "COM_AP",
                                 "COM displacement",
                                 "com_position",
                                 "com_pos",
                                 "HIP_x",
                                 "C7 X",
                                 "Tx",
                                 "LASI:Z",
                                 "Trunk Position X",
                                 "xCoM",
                                 "CM",
                                 "COG",
                                 "CoM",
                                 "CoM(ant-post)",
                                 "AP",
                                 "excursion",
                                 "string_pot",
                                 "StringPot",
                                 "sway rod",
                                 "waist",
                                 "sacrum",
                                 "L5",
                                 "marker1",
                                 "Marker 2",
                                 "hip",
                                 "LHip",
                                 "RASI"}) {
    CAPTURE(name);
    const Recording recording = read(text(name));
    REQUIRE(warning(recording.warnings, "perhaps_a_length") != nullptr);
    CHECK(warning(recording.warnings, "perhaps_a_length")->severity == Severity::caution);
    CHECK(recording.signals.at(com_sway).rad[1] == 2.0 * sim::rad_per_deg);
    CHECK(warning(read(text(name), {.unit = Unit::degree}).warnings, "perhaps_a_length") == nullptr);
    CHECK(warning(read(text(name + " (deg)")).warnings, "perhaps_a_length") == nullptr);
  }
  for (const char* name :
       {"sway",  "com_sway",  "COM_angle", "angle",  "lean",      "sway_x",   "Euler X", "Trunk Angle X",
        "KSP",   "body_sway", "sway (x)",  "pitch",  "sway_ap",   "hip_sway", "L5 tilt", "body",
        "trunk", "leg",       "shank",     "sway 2", "hip pitch", "period"}) {
    CAPTURE(std::string(name));
    CHECK(warning(read(text(name)).warnings, "perhaps_a_length") == nullptr);
  }
  check_error(reading(text("COM_x (centimetres)")), Code::column_unsuitable, "com_height");
  const Recording metres = read(text("COM_x (centimetres)"), {.com_height_m = 1.0});
  CHECK(near(metres.signals.at(com_sway).rad[1], std::asin(0.005), 1e-14));
  for (const char* name : {"COM_x (in)", "sway [counts]", "sway_mV", "sway_percent", "swayvel", "sway_std"}) {
    CAPTURE(std::string(name));
    check_error(reading(text(name)), Code::column_unsuitable, name);
    CHECK(read(text(name), {.unit = Unit::degree}).signals.at(com_sway).rad[1] == 2.0 * sim::rad_per_deg);
  }
}

TEST_CASE("the height of the centre of mass is compared with the person's") {
  const auto codes = [](double com_m, std::optional<double> body_m) {
    const Recording recording =
        read("time,x_mm\n0,1\n0.01,20\n0.02,3\n", {.com_height_m = com_m, .body_height_m = body_m});
    const Warning* found = warning(recording.warnings, "implausible_com_height");
    if (found != nullptr) CHECK(found->severity == (body_m ? Severity::caution : Severity::info));
    return found != nullptr;
  };
  CHECK_FALSE(codes(0.88, 1.6));
  CHECK_FALSE(codes(0.65, 1.6));
  CHECK(codes(1.2, 1.6));
  CHECK(codes(0.6, 1.6));
  check_error([&] { codes(1.8, 1.6); }, Code::setting_out_of_range, "com_height");
  CHECK_FALSE(codes(0.99, {}));
  CHECK(codes(1.8, {}));
  CHECK(codes(0.3, {}));
}

TEST_CASE("a unit option that is not a position's own unit is warned of") {
  const std::string rows = "\n0,1,10\n0.01,2,20\n0.02,4,30\n";
  const auto warned = [&](const std::string& name, double metres) {
    return warning(read("time," + name + ",x" + rows, {.column = "2", .com_height_m = 1.0, .metres_per_unit = metres})
                       .warnings,
                   "unit_differs") != nullptr;
  };
  CHECK(warned("COM_x_cm", 1e-3));
  CHECK(warned("COM_x (deg)", 1e-3));
  CHECK_FALSE(warned("COM_x_mm", 1e-3));
  CHECK_FALSE(warned("COM_x", 1e-3));
  const Recording markers =
      read("time,HIP_x [mm],SHO_x [m]\n0,1,2\n0.01,2,4\n0.02,4,7\n",
           {.hip_column = "2", .shoulder_column = "3", .body_height_m = 1.7, .metres_per_unit = 1e-3});
  REQUIRE(warning(markers.warnings, "unit_differs") != nullptr);
  CHECK(warning(markers.warnings, "unit_differs")->text.find("SHO_x [m]") != std::string::npos);
  // The advice of a small sway does not name an option that was given.
  const Recording small = read("time,COM_x_cm" + std::string("\n0,1\n0.01,1.2\n0.02,1.1\n"),
                               {.com_height_m = 1.0, .metres_per_unit = 1e-3});
  REQUIRE(warning(small.warnings, "small_sway") != nullptr);
  CHECK(warning(small.warnings, "small_sway")->text.find("com_height") == std::string::npos);
}
