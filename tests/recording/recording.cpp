// Recordings in many dialects, every error with its place and problem, and the fit to a protocol.
#include "recording/recording.hpp"

#include <cmath>
#include <cstdio>

#include "recording/trial.hpp"
#include "tests/helpers.hpp"
#include "tests/recording/table/reading.hpp"
#include "tests/sim/tiny_protocol.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

/// A cosine of 1 degree, 1 Hz, with a column of time.
std::string cosine(int samples, double rate_hz) {
  std::string text = "time,com_sway_deg\n";
  char line[64];
  for (int k = 0; k < samples; ++k) {
    std::snprintf(line, sizeof line, "%.9f,%.9f\n", k / rate_hz, std::cos(2.0 * sim::pi * k / rate_hz));
    text += line;
  }
  return text;
}

}  // namespace

TEST_CASE("times in seconds or milliseconds, with and without a header; a line of units") {
  // tests/recording/formats/csv.cpp has the separators, decimal commas, quotes and comments.
  check_one_two_three("time_ms,sway\n0,1\n10,2\n20,3\n");
  check_one_two_three("Time [ms];sway\n0;1\n10;2\n20;3\n");
  check_one_two_three("timestamp,sway\n1700000000.00,1\n1700000000.01,2\n1700000000.02,3\n");
  check_one_two_three("0,1\n0.01,2\n0.02,3\n");                    // no header
  check_one_two_three("1\n2\n3\n", {.rate_hz = 100.0});            // nor a time
  check_one_two_three("time,sway\ns,deg\n0,1\n0.01,2\n0.02,3\n");  // a line of units
  check_one_two_three("time , sway , note\n0, 1, start\n 0.01 ,2,\n0.02,3, \"a, b\"\n");
}

TEST_CASE("the sway is found by name, or named") {
  CHECK(read("time,tilt_deg,com_sway_deg\n0,9,1\n1,9,2\n", {}).signals.at(com_sway).column == "com_sway_deg");
  CHECK(read("COM_y,COM_x,time\n9,1,0\n9,2,0.01\n").signals.at(com_sway).column == "COM_x");
  CHECK(read("time,angle\n0,1\n0.01,2\n").signals.at(com_sway).column == "angle");
  CHECK(warns(read("time,angle\n0,1\n0.01,2\n"), "'angle' is assumed to be the sway"));
  CHECK_FALSE(warns(read("time,sway\n0,1\n0.01,2\n"), "is assumed to be the sway"));
  CHECK(read("time,a,b\n0,1,5\n0.01,2,6\n", {.column = "b"}).signals.at(com_sway).rad[0] == 5.0 * sim::rad_per_deg);
  CHECK(read("0,1,5\n0.01,2,6\n0.02,3,9\n", {.column = "2"}).signals.at(com_sway).column == "column 2");
  check_error(reading("time,a,b\n0,1,5\n0.01,2,6\n"), Code::column_ambiguous, "'a', 'b'");
  check_error(reading("time,a,b\n0,1,5\n0.01,2,6\n", {.column = "c"}), Code::column_missing, "'c'");
  check_error(reading("time,sway,x,sway,sway\n0,1,5,1,1\n0.01,2,6,1,1\n"), Code::column_ambiguous, "'sway'");
  CHECK(read("time,sway_deg,sway_rad\n0,1,5\n0.01,2,6\n").signals.at(com_sway).column == "sway_deg");  // two names
  check_error(reading("time\n0\n0.01\n"), Code::column_missing);
}

TEST_CASE("the time is found by name, and other names that begin with a T are not it") {
  check_one_two_three("T_ankle_Nm,time,sway_deg\n5,0,1\n4,0.01,2\n9,0.02,3\n");
  check_one_two_three("T_ankle_Nm,t (ms),sway_deg\n5,0,1\n4,10,2\n9,20,3\n");
  check_one_two_three("t_s,sway_deg\n0,1\n0.01,2\n0.02,3\n");
  check_one_two_three("t_rel,sway_deg\n0,1\n0.01,2\n0.02,3\n");  // there is no other
  check_error(reading("time,a\n0,1\n0.01,2\n", {.column = "time"}), Code::column_unsuitable, "'time'");
  CHECK(read("time,a\n0,1\n0.01,2\n", {.column = "time", .unit = Unit::degree, .rate_hz = 50.0}).rate_hz == 50.0);
}

TEST_CASE("the unit is the option's, else the name's, else degrees with a word about it") {
  const RecordingOptions at_100{.rate_hz = 100.0};
  CHECK(read("sway_deg\n1\n2\n", at_100).signals.at(com_sway).rad[1] == 2.0 * sim::rad_per_deg);
  CHECK(read("sway_deg\n1\n2\n", at_100).warnings.empty());
  CHECK(read("sway (deg)\n1\n2\n", at_100).warnings.empty());
  CHECK(read("sway_rad\n0.1\n0.2\n", at_100).signals.at(com_sway).rad[1] == 0.2);
  CHECK(read("sway [rad]\n0.1\n0.2\n", at_100).signals.at(com_sway).rad[1] == 0.2);
  CHECK(read("sway_deg\n0.1\n0.2\n", {.unit = Unit::radian, .rate_hz = 100.0}).signals.at(com_sway).rad[1] == 0.2);
  CHECK(read("sway_rad\n1\n2\n", {.unit = Unit::degree, .rate_hz = 100.0}).signals.at(com_sway).rad[1] ==
        2.0 * sim::rad_per_deg);
  CHECK(warns(read("sway\n1\n2\n", at_100), "assumes degrees"));
  for (const std::string name : {"sway_mrad", "sway (mrad)", "sway [milliradians]"}) {
    const Recording milli = read(name + "\n100\n200\n", at_100);
    CHECK(near(milli.signals.at(com_sway).rad[1], 0.2, 1e-15));
    CHECK(milli.warnings.empty());
  }
  CHECK(read("time,x,sway_mrad\n0,1,2\n0.01,2,3\n").signals.at(com_sway).column == "sway_mrad");
}

TEST_CASE("a tilt without a unit has the unit that is given for the sway, if that is an angle's") {
  const auto tilt_in = [](const std::string& name, const RecordingOptions& options) {
    return read("time,com_x_mm,sway," + name + "\n0,1,0.1,0.2\n0.01,2,0.2,0.2\n", options)
        .signals.at(platform_tilt)
        .rad[0];
  };
  for (const std::string column : {"", "platform"}) {
    RecordingOptions options{.column = "sway", .unit = Unit::radian, .tilt_column = column};
    CHECK(tilt_in("platform", options) == 0.2);
    CHECK(tilt_in("platform_deg", {.column = "sway", .unit = Unit::radian}) == 0.2 * sim::rad_per_deg);
    options.tilt_unit = Unit::degree;
    CHECK(tilt_in("platform", options) == 0.2 * sim::rad_per_deg);
  }
  CHECK(tilt_in("platform", {.column = "sway"}) == 0.2 * sim::rad_per_deg);
  CHECK(tilt_in("platform", {.column = "com_x_mm", .com_height_m = 1.0, .metres_per_unit = 1e-3}) ==
        0.2 * sim::rad_per_deg);
}

TEST_CASE("columns that are no angles by their names are refused, unless the unit is given") {
  const RecordingOptions at_100{.rate_hz = 100.0};
  const auto refused = [&](const std::string& name) {
    CAPTURE(name);
    check_error(reading(name + "\n1\n2\n", at_100), Code::column_unsuitable, name.c_str());
    CHECK(read(name + "\n1\n2\n", {.unit = Unit::degree, .rate_hz = 100.0}).signals.at(com_sway).rad[0] ==
          sim::rad_per_deg);
  };
  for (const char* name : {"sway_mm", "COM_x (m)"}) refused(name);
  for (const char* name : {"sway_deg/s", "sway_velocity_deg", "sway (rad/s2)"}) refused(name);
  check_error(reading("time,sway\ns,deg/s\n0,1\n0.01,2\n"), Code::column_unsuitable);
  check_error(reading("time,sway_deg,tilt_deg/s\n0,1,1\n0.01,2,2\n", {.tilt_column = "tilt_deg/s"}),
              Code::column_unsuitable, "tilt_unit");
  CHECK(read("time,sway_deg,tilt_mrad\n0,1,1\n0.01,2,2\n", {.tilt_column = "tilt_mrad"})
            .signals.at(platform_tilt)
            .rad[1] == 2.0 * 1e-3);
  // They matter only where the file has no angle.
  CHECK(read("time,sway_velocity_deg,sway_deg\n0,1,1\n0.01,2,2\n").signals.at(com_sway).column == "sway_deg");
}

TEST_CASE("the rate comes from the time, or from the user") {
  CHECK(read("time,sway\n0,1\n0.02,2\n0.04,3\n").rate_hz == 50.0);
  // 120 Hz to the microsecond: the steps differ, their mean does not.
  CHECK(read("time,sway\n0,1\n0.008333,2\n0.016667,3\n0.025,4\n").rate_hz == 120.0);
  CHECK(read("time,sway\n0,1\n0.01,2\n0.02009,3\n0.03,4\n").rate_hz == 100.0);
  check_error(reading("time,sway\n0,1\n0.01,2\n0.0231,3\n0.03,4\n0.04,5\n"), Code::times_uneven, "line 4");
  const Recording contradicted = read("time,sway\n0,1\n0.02,2\n0.04,3\n", {.rate_hz = 100.0});
  CHECK(contradicted.rate_hz == 100.0);
  CHECK(warns(contradicted, "gives 50 Hz"));
  CHECK(warns(contradicted, "given rate, 100 Hz"));
  CHECK_FALSE(warns(read("time,sway\n0,1\n0.02,2\n", {.rate_hz = 50.0}), "given"));
  CHECK(contains(read("time,sway\n0,1\n0.5,2\n1,3\n").rate_advice, "time_ms"));
  // Milliseconds taken for seconds, and seconds for milliseconds.
  check_error(reading("time,sway\n0,1\n10,2\n20,3\n"), Code::setting_out_of_range, "'time'");
  check_error(reading("time_us,sway\n0,1\n1,2\n2,3\n"), Code::setting_out_of_range, "'time_us'");
  CHECK(read("time,sway\n0,1\n10,2\n20,3\n", {.rate_hz = 100.0}).rate_hz == 100.0);
  check_error(reading("sway\n1\n2\n"), Code::rate_unknown, "r.csv");
  check_error(reading("time,sway\n0,1\n0.01,2\n0.02,3\n0.04,4\n"), Code::value_missing, "fill_gaps");
  check_error(reading("# c\n\ntime,sway\n0,1\n0.01,2\n0.01,3\n0.02,4\n"), Code::times_uneven, "line 6");
  check_error(reading("time,sway\n0.02,1\n0.01,2\n0,3\n"), Code::times_uneven, "'time'");
  check_error(reading("time,sway\n0,1\n0,2\n0,3\n"), Code::times_uneven, "line 3");
  check_error(reading("time,sway\n0,1\n0.01,2\n0.01,3\n0.01,4\n"), Code::times_uneven, "line 4");
  check_error(reading("time,sway\n0,1\nnoon,2\n0.02,3\n"), Code::value_invalid, "line 3, time");
  CHECK(warns(read("time,sway\n0,1\nnoon,2\n0.02,3\n", {.rate_hz = 100.0}), "ignores the time column"));
  for (const double rate : {0.0, -5.0, 0.99, 100'001.0, std::nan(""), HUGE_VAL}) {
    check_error(reading("sway\n1\n2\n", {.rate_hz = rate}), Code::setting_out_of_range, "1 to");
    check_error([&] { make_recording(std::vector<double>{0.01, 0.02}, rate); }, Code::setting_out_of_range, "1 to");
  }
  for (const double rate : {1.0, 100'000.0}) {
    CHECK(read("sway\n1\n2\n", {.rate_hz = rate}).rate_hz == rate);
    CHECK(make_recording(std::vector<double>{0.01, 0.02}, rate).rate_hz == rate);
  }
}

TEST_CASE("files that are no recordings are refused") {
  check_error([] { read_recording("/nonexistent/r.csv", {}); }, Code::file_missing, "/nonexistent/r.csv");
  check_error(reading("time,sway\n0,1\n"), Code::recording_too_short);
  check_error(reading("{\"decid\": \"0.2.0\",\n \"recordings\": []}\n"), Code::file_unsupported, "r.csv");
  check_error(reading("time,sway\nfirst,trial\n0,1\n0.01,2\n"), Code::value_invalid, "line 2");
  check_error(reading("time,sway\n0,1\n0.01,1\n0.02,1\n"), Code::value_invalid, "1 degrees");
  check_error(reading("time,sway\n0,1\n0.01,91\n"), Code::value_invalid, "sample 2");
  check_error(reading("time,sway\n0,1\n0.01,2\n", {.unit = Unit::radian}), Code::value_invalid, "115 degrees");
}

TEST_CASE("odd sizes of sway are remarked on") {
  const RecordingOptions at_100{.rate_hz = 100.0};
  const Recording large = read("sway_deg\n-21.2345\n2\n", at_100);
  CHECK(warns(large, "reaches 21.2 degrees"));
  CHECK(large.is_large);
  CHECK_FALSE(read("sway_deg\n-19\n2\n", at_100).is_large);
  CHECK(warns(read("sway_deg\n1\n1.0005\n", at_100), "only 0.0005 degrees peak to peak"));
  CHECK(read("sway_deg\n1\n1.002\n19\n", at_100).warnings.empty());
}

TEST_CASE("a sway without a unit that is too large for degrees is a caution, with a unit it is not") {
  const auto large = [](const std::string& text, std::optional<Unit> unit = {}) {
    const Recording recording = read(text, {.unit = unit, .rate_hz = 100.0});
    const bool warned = has(recording.warnings, "large_sway");
    CHECK(recording.is_large == warned);
    CHECK(worst_trust(recording.warnings) == (warned ? Trust::caution : Trust::usable));
    return warned;
  };
  const std::string wide = "\n-10.5\n0\n1\n0\n-1\n0\n1\n0\n0\n0\n0\n10.5\n", swinging = "\n-5.5\n5.5\n-5.5\n5.5\n";
  for (const std::string& samples : {wide, swinging}) {  // 21 degrees peak to peak; a standard deviation of 5.5
    CHECK(large("sway" + samples));
    CHECK_FALSE(large("sway" + samples, Unit::degree));
    CHECK_FALSE(large("sway_deg" + samples));
  }
  CHECK_FALSE(large("sway\n-4.9\n4.9\n-4.9\n4.9\n"));
}

TEST_CASE("samples in memory: errors and warnings name neither columns nor options") {
  const auto plain = [](const std::string& text) {
    INFO(text);
    for (const char* part : {"--", "column"}) CHECK_FALSE(contains(text, part));
  };
  for (const std::vector<double>& bad : {std::vector<double>{}, {0.1}, {0.1, 0.1}, {0.1, 2.0}, {0.1, std::nan("")}}) {
    const Error error = error_of([&] { make_recording(bad, 100.0); });
    CHECK(error.where() == "recording");
    plain(error.what());
  }
  for (const std::vector<double>& odd : {std::vector<double>{0.1, 0.5}, {0.1, 0.100001}}) {
    const Recording recording = make_recording(odd, 100.0);
    REQUIRE(recording.warnings.size() == 1);
    plain(recording.warnings.front().text);
  }
}

TEST_CASE("absurd sizes are refused") {
  std::string tall;
  for (int i = 0; i < 10'000'001; ++i) tall += "1\n";
  check_error(reading(tall), Code::file_too_large, "10 million");
}

TEST_CASE("a recording of the protocol's length is taken as it is") {
  const sim::Protocol protocol = tiny_protocol();  // 400 samples at 100 Hz
  Recording recording = read(cosine(400, 100.0));
  const std::vector<float> sway = bring_to_protocol(recording, protocol).sway_rad();
  REQUIRE(sway.size() == 400);
  for (std::size_t k = 0; k < sway.size(); ++k)
    CHECK(sway[k] == static_cast<float>(recording.signals.at(com_sway).rad[k]));
  CHECK(worst_trust(recording.warnings) == Trust::usable);
}

TEST_CASE("another rate is resampled") {
  const sim::Protocol protocol = tiny_protocol();
  for (const double rate : {50.0, 60.0, 250.0, 99.98}) {
    Recording recording = read(cosine(static_cast<int>(std::ceil(4.0 * rate)), rate));
    const std::vector<float> sway = bring_to_protocol(recording, protocol).sway_rad();
    REQUIRE(sway.size() == 400);
    CHECK(warns(recording, "resampled from"));
    double largest = 0.0;
    for (std::size_t k = 60; k < 340; ++k) {
      const double exact = std::cos(2.0 * sim::pi * static_cast<double>(k) / 100.0) * sim::rad_per_deg;
      largest = std::max(largest, std::abs(sway[k] - exact));
    }
    CHECK(largest < 1e-3 * sim::rad_per_deg);
  }
  // 0.005% off is the same rate.
  Recording close = read(cosine(400, 100.0), {.rate_hz = 100.005});
  CHECK(bring_to_protocol(close, protocol).sway_rad().size() == 400);
  CHECK_FALSE(warns(close, "resampled"));
  Recording wrong = read(cosine(400, 200.0));
  check_error([&] { bring_to_protocol(wrong, protocol); }, Code::recording_too_short, "400 samples");
}

TEST_CASE("an angle without a unit that is tiny in degrees is refused, as it may be in radians") {
  const auto text = [](const std::string& name) { return "time," + name + "\n0,0.0001\n0.01,0.0012\n0.02,0.0152\n"; };
  check_error(reading(text("sway")), Code::unit_unknown, "0.0151 degrees");
  CHECK(near(read(text("sway"), {.unit = Unit::radian}).signals.at(com_sway).rad[2], 0.0152, 1e-15));
  CHECK(near(read(text("sway_deg")).signals.at(com_sway).rad[2], 0.0152 * sim::rad_per_deg, 1e-15));
  CHECK(near(read(text("sway"), {.unit = Unit::degree}).signals.at(com_sway).rad[2], 0.0152 * sim::rad_per_deg, 1e-15));
}
