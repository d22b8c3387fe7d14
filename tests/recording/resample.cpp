// Resampling: sines below the cut-off come through, sines above it do not, and nothing else changes.
#include "recording/resample.hpp"

#include <cmath>

#include "recording/recording.hpp"
#include "sim/protocol/protocol.hpp"
#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

/// Rounding of a weighted mean of the 53 samples or so that the filter reaches.
constexpr double rounding = 53 * 0x1p-52;

struct Case {
  double from, to;
};

std::vector<double> sine(double frequency_hz, double rate_hz, std::size_t samples) {
  std::vector<double> signal(samples);
  for (std::size_t k = 0; k < samples; ++k) {
    signal[k] = std::sin(2.0 * sim::pi * frequency_hz * static_cast<double>(k) / rate_hz + 0.3);
  }
  return signal;
}

/// Largest difference from the sine, and largest value, away from the ends (the filter reaches 26 samples of the
/// lower rate).
struct Deviation {
  double from_sine, from_zero;
};
Deviation stddev(const std::vector<double>& signal, double frequency_hz, double rate_hz, double margin_s) {
  const std::vector<double> exact = sine(frequency_hz, rate_hz, signal.size());
  const auto margin = static_cast<std::size_t>(margin_s * rate_hz);
  Deviation largest{0.0, 0.0};
  REQUIRE(signal.size() > 2 * margin + 50);
  for (std::size_t k = margin; k + margin < signal.size(); ++k) {
    largest.from_sine = std::max(largest.from_sine, std::abs(signal[k] - exact[k]));
    largest.from_zero = std::max(largest.from_zero, std::abs(signal[k]));
  }
  return largest;
}

}  // namespace

TEST_CASE("a sine below the cut-off keeps amplitude and phase") {
  for (const Case& c : {Case{50, 100}, {100, 50}, {1000, 100}, {60, 100}, {128, 100}, {99.5, 100}, {240.3, 100}}) {
    const double lower = std::min(c.from, c.to);
    for (const double part : {0.003, 0.1, 0.3, 0.395}) {  // of the lower rate
      const double frequency = part * lower;
      const auto result = resample(sine(frequency, c.from, static_cast<std::size_t>(5 * c.from)), c.from, c.to);
      CAPTURE(c.from);
      CAPTURE(c.to);
      CAPTURE(part);
      CHECK(stddev(result, frequency, c.to, 27.0 / lower).from_sine < 1e-3);
    }
  }
}

TEST_CASE("a sine above the lower rate's Nyquist frequency is attenuated by more than 70 dB") {
  for (const double frequency : {51.0, 60.0, 99.0, 100.0, 101.0, 250.0, 333.0, 499.0}) {
    const auto result = resample(sine(frequency, 1000.0, 5000), 1000.0, 100.0);
    CAPTURE(frequency);
    CHECK(stddev(result, frequency, 100.0, 0.27).from_zero < 3.16e-4);
  }
  // The largest side lobes, beside the pass band, are where a weaker window would show.
  for (double frequency = 50.0; frequency < 56.0; frequency += 0.25) {
    const auto result = resample(sine(frequency, 1000.0, 5000), 1000.0, 100.0);
    CAPTURE(frequency);
    CHECK(stddev(result, frequency, 100.0, 0.27).from_zero < 1.5e-4);
  }
  // And the images that a higher rate would show.
  const auto raised = resample(sine(10.0, 50.0, 500), 50.0, 100.0);
  double image = 0.0;
  for (std::size_t k = 100; k < 900; ++k) image += raised[k] * std::cos(2.0 * sim::pi * 0.4 * static_cast<double>(k));
  CHECK(std::abs(image / 400.0) < 3.16e-4);
}

TEST_CASE("half-way down at 0.45 of the lower rate") {
  const auto result = resample(sine(45.0, 1000.0, 5000), 1000.0, 100.0);
  // Kaiser's window is symmetric about there, to its ripple of 80 dB; the samples stand within 1e-4 of the sine's peak.
  CHECK(near(stddev(result, 45.0, 100.0, 0.27).from_zero, 0.5, 1e-3));
}

TEST_CASE("the result is as long as the signal, and at equal rates a copy") {
  const std::vector<double> signal(6370, 1.0);
  CHECK(resample(signal, 50.0, 100.0).size() == 12740);
  CHECK(resample(signal, 100.0, 50.0).size() == 3185);
  CHECK(resample(signal, 49.99999999999, 100.0).size() == 12740);
  CHECK(resample(signal, 300.0, 100.0).size() == 2123);
  CHECK(resample({}, 50.0, 100.0).empty());
  CHECK(resample({1.0, -2.5, 1e-300, 4.0}, 100.0, 100.0) == std::vector{1.0, -2.5, 1e-300, 4.0});
}

TEST_CASE("ends are held: a constant stays itself up to both ends") {
  for (const double value : resample(std::vector<double>(40, 0.7), 60.0, 100.0)) {
    CHECK(near(value, 0.7, rounding));
  }
  // Far fewer samples than the filter reaches.
  for (const double value : resample({0.5, 0.5}, 1000.0, 999.0)) CHECK(near(value, 0.5, rounding));
}

TEST_CASE("one cycle of a periodic signal is exact all around") {
  // 2 to 8 periods in 10 s, so that the phase of 0.3 stands anywhere at the joint.
  for (const Case& c : {Case{20, 100}, {1000, 100}, {99.5, 100}, {240, 100}, {100, 100}}) {
    for (const double frequency : {0.2, 0.5, 0.8}) {
      const auto count = static_cast<std::size_t>(10 * c.to);
      const auto result = resample_cycle(sine(frequency, c.from, static_cast<std::size_t>(10 * c.from)), count);
      CAPTURE(c.from);
      CAPTURE(frequency);
      REQUIRE(result.size() == count);
      CHECK(stddev(result, frequency, c.to, 0.0).from_sine < 2e-4);
    }
  }
  // Far fewer samples than the filter reaches: it goes round more than once.
  for (const double value : resample_cycle({0.5, 0.5, 0.5}, 7)) CHECK(near(value, 0.5, rounding));
  const auto triangle = resample_cycle({1.0, -0.5, -0.5}, 12);  // cos(2 pi k / 3)
  for (std::size_t k = 0; k < 12; ++k) {
    CHECK(std::abs(triangle[k] - std::cos(2.0 * sim::pi * static_cast<double>(k) / 12.0)) < 1e-3);
  }
  CHECK(resample_cycle({}, 5).empty());
}

TEST_CASE("reflected ends: a movement goes on, where held ones stop it") {
  // A straight line has no end that could be seen: to 1e-3 of an old step, as in its middle.
  std::vector<double> line;
  for (int k = 0; k < 200; ++k) line.push_back(3.0 - 0.02 * k);
  for (const double rate : {100.0, 7.0}) {
    const auto result = resample(line, 20.0, rate, Ends::reflected);
    REQUIRE(result.size() == static_cast<std::size_t>(10.0 * rate));
    CHECK(near(result[0], 3.0, rounding));
    double error = 0.0;
    for (std::size_t k = 0; k < result.size(); ++k)
      error = std::max(error, std::abs(result[k] - (3.0 - 0.4 / rate * static_cast<double>(k))));
    CHECK(error < 1e-3 * 0.02);
  }
  // A signal much shorter than the filter.
  const auto two = resample({1.0, 2.0}, 10.0, 30.0, Ends::reflected);
  REQUIRE(two.size() == 6);
  for (std::size_t k = 0; k < 6; ++k) CHECK(std::abs(two[k] - (1.0 + static_cast<double>(k) / 3.0)) < 1e-3);
  for (const double value : resample({0.7}, 60.0, 100.0, Ends::reflected)) CHECK(near(value, 0.7, rounding));

  // Its curve is what a reflection turns over: 0.2 Hz at 20 samples a second, the velocity within 3% of the largest.
  const auto swing = resample(sine(0.2, 20.0, 200), 20.0, 100.0, Ends::reflected);
  const auto swing_held = resample(sine(0.2, 20.0, 200), 20.0, 100.0);
  double worst = 0.0, worst_held = 0.0;
  for (std::size_t k = 0; k + 1 < swing.size(); ++k) {
    const double exact = 0.4 * sim::pi * std::cos(0.4 * sim::pi * (static_cast<double>(k) + 0.5) / 100.0 + 0.3);
    worst = std::max(worst, std::abs((swing[k + 1] - swing[k]) * 100.0 - exact));
    worst_held = std::max(worst_held, std::abs((swing_held[k + 1] - swing_held[k]) * 100.0 - exact));
  }
  CHECK(worst < 0.03 * 0.4 * sim::pi);
  CHECK(worst_held > 0.5 * 0.4 * sim::pi);
}

TEST_CASE("impossible rates are refused") {
  const std::vector<double> signal(10, 1.0);
  for (const double rate : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
    check_error([&] { resample(signal, rate, 100.0); }, Code::setting_out_of_range);
    check_error([&] { resample(signal, 100.0, rate); }, Code::setting_out_of_range);
  }
  check_error([&] { resample(signal, 1e-9, 100.0); }, Code::setting_out_of_range, "100 million");
}
