// Sample rates in words: phrases that state one, phrases that state something else, and files with several.
#include "recording/detail/stated_rate.hpp"

#include <string>

#include "tests/recording/table/reading.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

/// The rates of a line that count.
std::vector<double> rates_of(const std::string& line) {
  std::vector<StatedRate> rates;
  add_stated_rates(line, rates);
  std::vector<double> hz;
  for (const StatedRate& rate : candidates(rates)) hz.push_back(rate.hz);
  return hz;
}

const std::string three_rows = "x,sway_deg\n5,1\n5,2\n5,3\n";

}  // namespace

TEST_CASE("phrases that state a sample rate") {
  for (const char* line :
       {"DataRate,100 Hz,", "Frequency: 100", "Abtastfrequenz\t=\t100", "100 FPS", "Sampling rate (Hz):\t100",
        "// Update Rate: 100.0Hz", "FREQUENCY\t100", "sample_rate_hz = 100", "Sampling rate 100 Hz", "fs=100",
        "Capture Frame Rate,100.000000,Export Frame Rate,100.000000", "Abtastrate;100,0", "samplingFrequency: 0.1 kHz",
        "Interval=\t0.01 s", "10 msec/sample", "Delta_X\t0.010000\t0.010000\t", "Sampling interval (ms),10",
        "Fr\xC3\xA9quence d'\xC3\xA9"
        "chantillonnage : 100 Hz"}) {
    INFO(std::string(line));
    CHECK(rates_of(line) == std::vector<double>{100.0});
  }
  CHECK(rates_of("Sampling rate: 62,5") == std::vector<double>{62.5});
  CHECK(rates_of("Rate,50,1000") == std::vector<double>{50.0});
}

TEST_CASE("phrases that state something else") {
  for (const char* line : {"Offset,12.5",
                           "Generated,2021",
                           "Calibrated 2019",
                           "Cutoff frequency,20",
                           "Low-pass cutoff frequency: 50 Hz",
                           "Heart rate,72",
                           "Mocap Rate Multiple,1.00",
                           "ANALOG_FREQUENCY\t1000",
                           "Stimulus frequency (Hz),2",
                           "Frequency: 100 200",
                           "Frequency: 0.5",
                           "Frequency: none",
                           "Gain: 100",
                           "100",
                           "Frequency: 1e9",
                           "Rate: 3 of 5",
                           "Interval,5",
                           "Strategy,3",
                           "10 s",
                           "Sampling rate:"}) {
    INFO(std::string(line));
    CHECK(rates_of(line).empty());
  }
}

TEST_CASE("a rate that says whose it is counts before one that does not; two of them are a question") {
  CHECK(rates_of("Sampling rate,100,Frequency,2") == std::vector<double>{100.0});
  CHECK(rates_of("Sampling rate,100,Frame rate,100") == std::vector<double>{100.0});
  CHECK(rates_of("Sampling rate,1000,Frame rate,100") == std::vector<double>{1000.0, 100.0});
  check_one_two_three("Sampling rate,100\nCutoff frequency,20\nOffset,12.5\n" + three_rows);
  check_one_two_three(
      "NO_OF_FRAMES\t3\nFREQUENCY\t100\nANALOG_FREQUENCY\t1000\nx\ty\tsway_deg\n5\t6\t1\n5\t6\t2\n5\t6\t3\n");
  check_error(reading("Sampling rate,1000\nFrame rate,100\n" + three_rows), Code::rate_unknown, "'Sampling rate'");
  check_one_two_three("Sampling rate,1000\nFrame rate,100\n" + three_rows, {.rate_hz = 100.0});
  check_error(reading("Heart rate,72\nCutoff frequency,20\n" + three_rows), Code::rate_unknown);
}

TEST_CASE("a rate that was stated is said, and only where it is used") {
  const Recording stated = read("Sampling rate,100\n" + three_rows);
  REQUIRE(warning(stated.warnings, "rate_stated") != nullptr);
  CHECK(warning(stated.warnings, "rate_stated")->severity == Severity::info);
  CHECK(contains(warning(stated.warnings, "rate_stated")->text, "100 Hz by 'Sampling rate'"));
  CHECK(warning(read("Sampling rate,200\n" + three_rows, {.rate_hz = 100.0}).warnings, "rate_stated") == nullptr);
  CHECK(warning(read("Sampling rate,200\ntime,sway_deg\n0,1\n0.01,2\n0.02,3\n").warnings, "rate_stated") == nullptr);
}
