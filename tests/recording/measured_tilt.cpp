// Measured tilts of protocols: files, columns, units, rates and resampled cycles.
#include <cmath>
#include <cstdio>

#include "recording/protocol_file.hpp"
#include "sim/protocol/protocol_json.hpp"
#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

TEST_CASE("a measured tilt is read from the file beside its protocol") {
  const TemporaryFolder folder;
  std::string csv = "time,fs_deg,other\n";
  for (int k = 0; k < 50; ++k) csv += std::to_string(k * 0.01) + "," + std::to_string(0.125 * (k % 8) + 1.0) + ",1\n";
  write_text(folder / "tilt.csv", csv);
  const auto load = [&](const std::string& measured, const std::string& more = "") {
    return load_protocol(write_text(folder / "p.json", R"({"measured": {)" + measured + "}" + more + "}").string());
  };
  const sim::Protocol protocol = load(R"("file": "tilt.csv", "cycles": 2)");
  const auto& tilt = std::get<sim::MeasuredTilt>(protocol.experiment.stimulus).tilt_deg;
  REQUIRE(tilt.size() == 50);
  for (std::size_t k = 0; k < 50; ++k) CHECK(tilt[k] == 0.125 * static_cast<double>(k % 8) + 1.0);
  CHECK(protocol.samples() == 100);
  // Its JSON needs the file no more.
  std::filesystem::remove(folder / "tilt.csv");
  CHECK(sim::protocol_from_json(to_json(protocol), "copy").experiment.stimulus == protocol.experiment.stimulus);

  // By number, in radians, without header and time, at half the rate: the resampler's work.
  std::string plain;
  for (int k = 0; k < 500; ++k) plain += "7 " + std::to_string(0.017 * std::sin(0.02 * k)) + "\n";
  write_text(folder / "plain.txt", plain);
  const sim::Protocol slow = load(R"("file": "plain.txt", "column": "2", "unit": "rad", "rate_hz": 50)");
  const auto& resampled = std::get<sim::MeasuredTilt>(slow.experiment.stimulus).tilt_deg;
  REQUIRE(resampled.size() == 1000);
  // Text of six decimals, and the resampler's 80 dB.
  for (std::size_t k = 100; k < 900; ++k)
    CHECK(std::abs(resampled[k] - 0.017 * std::sin(0.01 * static_cast<double>(k)) / sim::rad_per_deg) <
          (0.5e-6 + 0.017e-4) / sim::rad_per_deg);
  // In thousandths of a radian, and a column of time that is said to be the tilt: both are degrees in the end.
  write_text(folder / "milli.csv", "time,tilt_mrad\n0,0\n0.01,10\n0.02,20\n");
  const sim::Protocol milli = load(R"("file": "milli.csv", "lead_out_s": 2)");
  const auto& radians = std::get<sim::MeasuredTilt>(milli.experiment.stimulus).tilt_deg;
  REQUIRE(radians.size() == 3);
  CHECK(radians[2] == 20.0 * 1e-3 / sim::rad_per_deg);
  const sim::Protocol times =
      load(R"("file": "milli.csv", "column": "time", "unit": "deg", "rate_hz": 100, "lead_out_s": 2)");
  CHECK(std::get<sim::MeasuredTilt>(times.experiment.stimulus).tilt_deg == std::vector{0.0, 0.01, 0.02});
  // A column alone is the tilt, whatever it is called.
  write_text(folder / "alone.csv", "time,platform_deg\n0,0\n0.01,1\n0.02,2\n");
  CHECK(std::get<sim::MeasuredTilt>(load(R"("file": "alone.csv", "lead_out_s": 2)").experiment.stimulus).tilt_deg ==
        std::vector{0.0, 1.0, 2.0});
  // An absolute name is itself.
  CHECK(load("\"file\": \"" + (folder / "plain.txt").string() + R"(", "column": "2", "unit": "rad", "rate_hz": 50)")
            .experiment.stimulus == slow.experiment.stimulus);
}

TEST_CASE("measured tilts that cannot be read are refused with file and setting") {
  const TemporaryFolder folder;
  const auto check = [&](const std::string& csv, const std::string& measured, Code code, std::string_view fact = {}) {
    write_text(folder / "t.csv", csv);
    const auto path = write_text(folder / "p.json", R"({"measured": {)" + measured + "}}");
    INFO(csv, measured);
    check_error([&] { load_protocol(path.string()); }, code, fact);
  };
  const std::string good = "time,tilt_deg\n0,0\n0.01,1\n0.02,2\n";
  const char* file = R"("file": "t.csv")";
  check(good, R"("file": "none.csv")", Code::file_missing, "'measured.file'");
  check(good, R"("file": "")", Code::file_unreadable, "'measured.file'");
  check(good, R"("file": 3)", Code::setting_malformed, "'measured.file'");
  check(good, R"("file": "t.csv", "column": "x")", Code::column_missing, "'x'");
  check(good, R"("file": "t.csv", "column": 2)", Code::setting_malformed, "'measured.column'");
  check(good, R"("file": "t.csv", "unit": "m")", Code::setting_malformed, "'measured.unit'");
  check(good, R"("file": "t.csv", "rate_hz": 0)", Code::setting_out_of_range, "measured.rate_hz");
  check(good, R"("file": "t.csv", "rate_hz": 0.99)", Code::setting_out_of_range, "measured.rate_hz");
  check(good, R"("file": "t.csv", "rate_hz": 1e9)", Code::setting_out_of_range, "measured.rate_hz");
  check("time,tilt_deg\n0,0\n10,1\n20,0\n", file, Code::setting_out_of_range, "time_ms");
  check("tilt_deg\n1\n2\n", R"("file": "t.csv", "rate_hz": 100000)", Code::setting_out_of_range, "0 at");
  check("time,tilt,tilt\n0,0,0\n0.01,1,1\n", file, Code::column_ambiguous, "'tilt'");
  check("time,tilt_deg/s\n0,0\n0.01,1\n", file, Code::column_unsuitable, "measured.unit");
  check(good, R"("file": "t.csv", "angle": 1)", Code::setting_unknown, "'measured.angle'");
  check(good, R"("file": "t.csv", "lead_in_s": 0.005)", Code::setting_out_of_range, "lead_in_s");
  check(good, R"("file": "t.csv", "rate_hz": 50)", Code::setting_conflict, "measured.rate_hz");
  check("", file, Code::file_empty, "p.json");
  check("tilt_deg\n1\n2\n", file, Code::rate_unknown, "measured.rate_hz");
  check("time,tilt_deg\n0,0\n", file, Code::recording_too_short, "t.csv");
  check("time,tilt_deg\n0,0\n0.01,nan\n", file, Code::value_missing, "line 3");
  check("time,tilt_deg\n0,0\n0.01,\n", file, Code::value_missing, "line 3");
  check("time,tilt_deg\n0,0\n,1\n", file, Code::value_missing, "line 3, time");
  // `fill_gaps` is an option of recordings only.
  for (const char* cells : {"nan,1", "0.01,", "0.01,nan"}) {
    write_text(folder / "t.csv", std::string("time,tilt_deg\n0,0\n") + cells + "\n");
    CHECK_FALSE(contains(message_of([&] { load_protocol((folder / "p.json").string()); }), "fill_gaps"));
  }
  check("time,tilt_deg\n0,0\n0.01,x\n", file, Code::value_invalid, "line 3");
  check("time,tilt_deg\n0,0\n0.01,1\n0.03,2\n0.04,3\n0.05,3\n", file, Code::times_uneven, "line 4");
  check("time,a_deg,b_deg\n0,0,0\n0.01,1,1\n", file, Code::column_ambiguous, "'a_deg', 'b_deg'");
  check("time,tilt\n0,0\n0.01,1\n", file, Code::unit_unknown, "measured.unit");
  check("time,tilt_rad\n0,0\n0.01,1\n", R"("file": "t.csv", "unit": "deg")", Code::setting_conflict, "measured.unit");
  check("time,tilt_mrad\n0,0\n0.01,1\n", R"("file": "t.csv", "unit": "rad")", Code::setting_conflict, "measured.unit");
  check("time,tilt_deg\n0,0\n0.01,50\n", file, Code::setting_out_of_range, "sample 1");
  check("time\n0\n0.01\n0.02\n", file, Code::column_missing, "measured.column");
  // A note reports the part of the file that was left out.
  write_text(folder / "t.csv", "time,tilt_deg\n0,0\n0.01,1\n0.02,1\n0.03,0\n0.04,");
  Warnings warnings;
  const auto cut = write_text(folder / "p.json", R"({"measured": {"file": "t.csv", "lead_out_s": 2}})");
  const sim::Protocol protocol = load_protocol(cut.string(), nullptr, &warnings);
  CHECK(std::get<sim::MeasuredTilt>(protocol.experiment.stimulus).tilt_deg.size() == 4);
  REQUIRE(warnings.size() == 1);
  CHECK(warnings[0].code == "last_line_cut");
  // The sample rate's error comes first.
  const auto path = write_text(folder / "p.json", R"({"sample_rate_hz": -5, "measured": {"file": "t.csv"}})");
  check_error([&] { load_protocol(path.string()); }, Code::setting_out_of_range, "sample_rate_hz");
}

TEST_CASE("a rate that is given beside times") {
  const TemporaryFolder folder;
  const auto samples = [&](const std::string& csv) {
    write_text(folder / "t.csv", csv);
    const std::string text = R"({"measured": {"file": "t.csv", "rate_hz": 100, "lead_out_s": 2}})";
    return std::get<sim::MeasuredTilt>(load_protocol(write_text(folder / "p.json", text).string()).experiment.stimulus)
        .tilt_deg;
  };
  // Rounded times that are even are 1% off at most; uneven ones may be of no use.
  CHECK(samples("time,tilt_deg\n0,0\n0.0099,1\n0.0198,2\n").size() == 3);
  CHECK(samples("time,tilt_deg\n0,0\n0.01,1\n0.03,2\n0.04,3\n0.05,3\n").size() == 5);
  CHECK(samples("time,tilt_deg\n0,0\n0,1\n0,2\n0,3\n").size() == 4);
  check_error([&] { samples("time,tilt_deg\n0,0\n0.0098,1\n0.0196,2\n"); }, Code::setting_conflict, "100");
}

TEST_CASE("a measured cycle that is resampled goes round") {
  const TemporaryFolder folder;
  // 0.2 Hz, 1 degree, 10 s: two whole periods, so that three cycles are one sine.
  const auto write = [&](double rate_hz, int samples, double phase) {
    std::string csv = "time,tilt_deg\n";
    for (int k = 0; k < samples; ++k) {
      char line[80];
      std::snprintf(line, sizeof line, "%.10f,%.15f\n", k / rate_hz, std::sin(0.4 * sim::pi * k / rate_hz + phase));
      csv += line;
    }
    write_text(folder / "t.csv", csv);
  };
  const auto load = [&](const std::string& more = "") {
    const std::string text = R"({"measured": {"file": "t.csv", "cycles": 3)" + more + "}}";
    return load_protocol(write_text(folder / "p.json", text).string());
  };
  for (const double rate_hz : {20.0, 50.0, 128.0, 1000.0}) {
    for (const double phase : {0.0, 1.0, 2.5}) {
      write(rate_hz, static_cast<int>(10 * rate_hz), phase);
      const sim::Protocol protocol = load();
      REQUIRE(protocol.samples() == 3000);
      const sim::Stimulus stimulus = sim::make_stimulus(protocol.experiment);
      double worst = 0.0;
      for (int k = 0; k + 1 < 3000; ++k) {
        const double exact = 0.4 * sim::pi * std::cos(0.4 * sim::pi * (k + 0.5) / 100.0 + phase);
        worst = std::max(worst, std::abs(stimulus.rate_at(10 * k) / sim::rad_per_deg - exact));
      }
      CAPTURE(rate_hz);
      CHECK(worst < 0.01 * 0.4 * sim::pi);
    }
  }
  // A cycle that is no whole number of samples at 100 Hz would be shortened and move away from the platform's.
  write(1000.0, 10'004, 0.0);
  check_error([&] { load(); }, Code::setting_out_of_range, "10004 samples");
  // A period and a half joins, as far as can be seen; a period and a quarter does not.
  write(20.0, 150, 0.0);
  CHECK_NOTHROW(load());
  for (const double rate_hz : {20.0, 100.0}) {
    write(rate_hz, static_cast<int>(6.25 * rate_hz), 0.0);
    check_error([&] { load(); }, Code::setting_out_of_range, "0.99");
  }
}
