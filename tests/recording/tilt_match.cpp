// The start of a stimulus in a measured tilt: against correlations written straight down, and between samples.
#include "recording/detail/tilt/tilt_match.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/math/random.hpp"
#include "recording/detail/tilt/tilt_gaps.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

Match match_tilt(const std::vector<double>& measured, const std::vector<double>& expected, int overhang) {
  return TiltMatcher(expected, overhang).match(measured);
}

std::vector<double> noise(std::size_t samples, std::uint64_t item) {
  const Random random(3, sim::streams::sensor_noise, item);
  std::vector<double> signal(samples);
  for (std::size_t k = 0; k < samples; ++k) signal[k] = random.normal(k);
  return signal;
}

/// Pearson's correlation of `expected` with as many samples of `measured` from `delay` on, and the slope of the line of
/// least squares; the ends of `measured` are held.
struct Direct {
  double correlation, slope;
};
Direct direct(const std::vector<double>& measured, const std::vector<double>& expected, int delay) {
  const auto n = static_cast<double>(expected.size());
  const auto at = [&](std::size_t k) {
    const int place = delay + static_cast<int>(k), last = static_cast<int>(measured.size()) - 1;
    return measured[static_cast<std::size_t>(std::clamp(place, 0, last))];
  };
  double mean_x = 0, mean_y = 0, xx = 0, xy = 0, yy = 0;
  for (std::size_t k = 0; k < expected.size(); ++k) {
    mean_x += expected[k] / n;
    mean_y += at(k) / n;
  }
  for (std::size_t k = 0; k < expected.size(); ++k) {
    xx += (expected[k] - mean_x) * (expected[k] - mean_x);
    xy += (expected[k] - mean_x) * (at(k) - mean_y);
    yy += (at(k) - mean_y) * (at(k) - mean_y);
  }
  return {yy > 0 ? xy / std::sqrt(xx * yy) : 0, xy / xx};
}

/// exp(-(t / width)^2 / 2) about `centre`.
std::vector<double> pulse(std::size_t samples, double centre, double width = 20) {
  std::vector<double> signal(samples);
  for (std::size_t k = 0; k < samples; ++k) {
    const double t = (static_cast<double>(k) - centre) / width;
    signal[k] = std::exp(-0.5 * t * t);
  }
  return signal;
}

std::vector<double> joined(std::vector<double> a, const std::vector<double>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// Rounding of FFTs and sums of some hundred numbers of the size of 1.
constexpr double rounding = 1e-12;

}  // namespace

TEST_CASE("tilt match: of all delays the one of largest correlation, as by the sums of its definition") {
  for (std::uint64_t item = 0; item < 40; ++item) {
    CAPTURE(item);
    const int overhang = static_cast<int>(item % 9);
    const std::vector<double> measured = noise(37 + item, item), expected = noise(30, 100 + item);
    int best = -overhang;
    const int last = static_cast<int>(measured.size()) - 30 + overhang;
    const auto correlation = [&](int delay) { return direct(measured, expected, delay).correlation; };
    int positive = best;
    for (int delay = best; delay <= last; ++delay) {
      if (std::abs(correlation(delay)) > std::abs(correlation(best))) best = delay;
      if (correlation(delay) > correlation(positive)) positive = delay;
    }
    const bool has_sign = correlation(positive) >= std::abs(correlation(best)) - 0.01;
    if (has_sign) best = positive;
    const auto size = [&](int delay) { return has_sign ? correlation(delay) : std::abs(correlation(delay)); };
    double between = 0;
    if (best > -overhang && best < last) {
      const double before = size(best - 1), after = size(best + 1);
      between = 0.5 * (before - after) / (before - 2 * size(best) + after);
    }
    const Match match = match_tilt(measured, expected, overhang);
    CHECK(within(match.delay_samples, best + between, 10 * rounding));  // a quotient of differences
    CHECK(within(match.correlation, direct(measured, expected, best).correlation, rounding));
    CHECK(within(match.gain, direct(measured, expected, best).slope, rounding));
  }
}

TEST_CASE("tilt match: the delay between samples, gain and sign") {
  const std::vector<double> expected = pulse(200, 100);
  // The correlation of two pulses is one of sqrt(2) times the width, W: about its peak 1 - x^2 / 2 W^2 + x^4 / 8 W^4,
  // whose last term shifts the parabola's peak by less than 1 / (8 W^2).
  const double bound = 1.0 / (8 * 2 * 20.0 * 20.0);
  // At 5 widths pulses are cut: exp(-5^2) of the correlation, over its curvature, 1 / W^2; a little more as they add
  // up.
  const double cut = 100 * std::exp(-25.0) * 800;
  for (const double delay : {0.0, 17.0, 33.25, 61.5, 99.8}) {
    for (const double gain : {1.0, 1.25, -1.0, -0.3}) {
      CAPTURE(delay);
      CAPTURE(gain);
      std::vector<double> measured = pulse(300, 100 + delay);
      for (double& value : measured) value = 0.7 + gain * value;
      const Match match = match_tilt(measured, expected, 20);
      CHECK(within(match.delay_samples, delay, std::round(delay) == delay ? cut : bound));
      // Half a sample of the pulse's steepest, exp(-1/2) / 20, at most.
      CHECK(within(match.correlation, std::copysign(1.0, gain), 1e-3));
      CHECK(near(match.gain, gain, 1e-3));
    }
  }
}

TEST_CASE("tilt match: a measurement that starts late or ends early is found as far as the overhang goes") {
  // The pulse stands in the middle of much rest, which held ends continue.
  const std::vector<double> expected = pulse(400, 200);
  const std::vector<double> late = pulse(390, 190), early = pulse(395, 205);
  CHECK(within(match_tilt(late, expected, 20).delay_samples, -10.0, 1e-9));
  CHECK(within(match_tilt(early, expected, 20).delay_samples, 5.0, 1e-9));
  CHECK(match_tilt(late, expected, 7).delay_samples == -7.0);  // at the end of the range no parabola
  CHECK(match_tilt(late, expected, 7).correlation < 0.999);
}

TEST_CASE("tilt match: a stimulus that repeats is taken the first time it is as good as ever") {
  const std::vector<double> expected = pulse(200, 100);
  const auto found = [&](double worse) {
    // Noise beside the pulse lowers the first correlation by half the noise's square.
    const std::vector<double> random = noise(200, 7);
    std::vector<double> first = expected;
    for (std::size_t k = 0; k < 200; ++k) first[k] += worse * random[k];
    return match_tilt(joined(first, expected), expected, 0).delay_samples;
  };
  CHECK(std::abs(found(0)) < 0.5);
  CHECK(std::abs(found(1e-4)) < 0.5);       // 1e-8 or so less, as of roundings in a file
  CHECK(std::abs(found(0.1) - 200) < 0.5);  // 1e-2: another
}

TEST_CASE("tilt match: a stimulus whose second half is its first half inverted is found with its own sign") {
  std::vector<double> expected = pulse(200, 100, 10);
  for (std::size_t k = 0; k < 200; ++k) expected.push_back(-expected[k]);
  for (const std::uint64_t item : {1U, 2U, 3U, 4U}) {
    CAPTURE(item);
    // Recorded from 50 samples after a start on, for two cycles and more.
    std::vector<double> measured = noise(900, item);
    for (std::size_t k = 0; k < measured.size(); ++k) measured[k] = 0.01 * measured[k] + expected[(k + 50) % 400];
    const Match match = match_tilt(measured, expected, 0);
    CHECK(match.correlation > 0.99);
    CHECK(std::abs(match.delay_samples - 350) < 0.5);
    // A gap leaves less to compare at this start than at the inverted one, at 150.
    Recording recording;
    recording.signals.add({platform_tilt, "tilt", measured});
    recording.tilt_gaps = {{700, 720}};
    CHECK(std::abs(start_beside_gaps(recording, measured, expected, 100.0, 100.0) - 3.5) < 0.005);
    // An inverted tilt between rests is found as such: half a stimulus later only a part of it is left to compare.
    std::vector<double> inverted = joined(std::vector<double>(100, 0.0), expected);
    inverted.resize(600, 0.0);
    for (double& value : inverted) value = -value;
    CHECK(std::abs(match_tilt(inverted, expected, 100).delay_samples - 100) < 0.5);
    recording.signals.at(platform_tilt).rad = inverted;
    recording.tilt_gaps = {{200, 210}};
    CHECK(std::abs(start_beside_gaps(recording, inverted, expected, 100.0, 100.0) - 1.0) < 0.005);
  }
}

TEST_CASE("tilt match: one matcher, recordings of any length") {
  const std::vector<double> expected = pulse(200, 100);
  const TiltMatcher matcher(expected, 20);
  for (const std::size_t samples : {300U, 200U, 5000U, 300U}) {  // transforms of two lengths
    CAPTURE(samples);
    const std::vector<double> measured = joined(pulse(samples, 120), noise(samples, samples));
    const Match match = matcher.match(measured), alone = match_tilt(measured, expected, 20);
    CHECK(match.delay_samples == alone.delay_samples);
    CHECK(match.correlation == alone.correlation);
    CHECK(match.gain == alone.gain);
  }
}

TEST_CASE("tilt match: nothing to be found") {
  const std::vector<double> expected = pulse(200, 100);
  for (const double value : {0.0, 1.0, 0.4, -1.0 / 3, 1e-9, 1e9}) {  // whose means are rounded
    CAPTURE(value);
    CHECK(match_tilt(std::vector<double>(300, value), expected, 20).correlation == 0.0);
    const Match unmoved = match_tilt(pulse(300, 120), std::vector<double>(200, value), 20);
    CHECK(unmoved.correlation == 0.0);
    CHECK(unmoved.gain == 0.0);
  }
  // Small is not constant.
  std::vector<double> small = pulse(300, 120);
  for (double& value : small) value = 1 + 1e-6 * value;
  CHECK(match_tilt(small, expected, 20).correlation > 0.999);
  // Less than what is expected, even with the overhang at both ends; then just enough.
  CHECK(match_tilt(pulse(159, 79), expected, 20).correlation == 0.0);
  CHECK(match_tilt(pulse(160, 80), expected, 20).correlation > 0.99);
}
