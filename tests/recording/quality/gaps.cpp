// Stretches of a sway that were not measured: found where they are, in files of few digits too, and nowhere else.
#include "recording/quality/detail/gaps.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/math/random.hpp"
#include "recording/trial.hpp"
#include "sim/protocol/protocol.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

constexpr double rate_hz = 100.0;

/// Slow sway of a degree with white noise, in degrees, rounded to `step`.
std::vector<double> sway(double noise_deg, double step, std::size_t samples = 12100) {
  const Random random(8, sim::streams::sensor_noise, 0);
  std::vector<double> values(samples);
  for (std::size_t k = 0; k < samples; ++k) {
    const double t = static_cast<double>(k) / rate_hz;
    values[k] = std::sin(1.3 * t) + 0.3 * std::sin(4.1 * t) + noise_deg * random.normal(k);
    if (step > 0.0) values[k] = step * std::round(values[k] / step);
  }
  return values;
}

/// Replaces the samples of a range by a line through its neighbours, rounded to `step`.
void bridge(std::vector<double>& values, SampleRange range, double step = 0.0) {
  const double before = values[range.first - 1],
               rise = (values[range.end] - before) / static_cast<double>(range.size() + 1);
  for (std::size_t k = range.first; k < range.end; ++k) {
    values[k] = before + rise * static_cast<double>(k - range.first + 1);
    if (step > 0.0) values[k] = step * std::round(values[k] / step);
  }
}

bool is_about(const SampleRange& found, const SampleRange& made) {
  const auto close = [](std::size_t a, std::size_t b) { return std::max(a, b) - std::min(a, b) <= 2; };
  return close(found.first, made.first) && close(found.end, made.end);
}

}  // namespace

TEST_CASE("straight lines between measured samples are found, in files of few digits too") {
  for (const double step : {0.0, 1e-6, 1e-3}) {
    CAPTURE(step);
    std::vector<double> values = sway(0.02, step);
    const std::vector<SampleRange> made{{3000, 3200}, {7000, 7012}};
    for (const SampleRange& range : made) bridge(values, range, step);
    for (double& value : values) value = double{static_cast<float>(value * sim::rad_per_deg)};
    const std::vector<SampleRange> found = find_stretches(values, rate_hz).straight;
    REQUIRE(found.size() == 2);
    for (std::size_t i = 0; i < 2; ++i) CHECK(is_about(found[i], made[i]));
    CHECK(find_stretches(values, rate_hz).frozen.empty());
  }
}

TEST_CASE("sway that was measured has no straight lines: fine, coarse, smooth, interpolated, held") {
  CHECK(find_stretches(sway(0.02, 0.0), rate_hz).straight.empty());
  CHECK(find_stretches(sway(0.0, 0.0), rate_hz).straight.empty());
  for (const double step : {1e-3, 0.02, 0.1}) CHECK(find_stretches(sway(0.02, step), rate_hz).straight.empty());
  for (const double step : {1e-4, 1e-3, 0.02}) CHECK(find_stretches(sway(0.0, step), rate_hz).straight.empty());
  for (const std::size_t every : {std::size_t{2}, std::size_t{5}, std::size_t{20}}) {
    CAPTURE(every);
    std::vector<double> interpolated = sway(0.02, 0.0, 12001), held = interpolated;
    for (std::size_t k = 0; k + every < interpolated.size(); k += every) {
      if (every > 1) bridge(interpolated, {k + 1, k + every});
      std::fill_n(held.begin() + static_cast<std::ptrdiff_t>(k), every, held[k]);
    }
    CHECK(find_stretches(interpolated, rate_hz).straight.empty());
    CHECK(find_stretches(held, rate_hz).straight.empty());
    CHECK(find_stretches(held, rate_hz).frozen.empty());
  }
  CHECK(find_stretches(std::vector<double>(2, 0.1), rate_hz).straight.empty());
  CHECK(find_stretches({}, rate_hz).frozen.empty());
  // A coarse sensor may stand still for long, at a turn of the sway.
  std::vector<double> coarse = sway(0.02, 0.2);
  std::fill_n(coarse.begin() + 4000, 900, coarse[4000]);
  CHECK(!find_stretches(coarse, rate_hz).frozen.empty());
  CHECK(find_stretches(coarse, rate_hz).unmeasured.empty());
  // A fine file of few digits, whose sway has no noise, stays within a digit at every turn.
  for (const double step : {1e-4, 1e-3, 1e-2}) CHECK(find_stretches(sway(0.0, step), rate_hz).unmeasured.empty());
}

TEST_CASE("a stretch of more than half of a recording is found, frozen or bridged, in one piece or several") {
  for (const double fraction : {0.49, 0.6}) {
    for (const double step : {0.0, 1e-4}) {
      CAPTURE(fraction);
      CAPTURE(step);
      std::vector<double> frozen = sway(0.02, step), bridged = frozen, pieces = frozen;
      const SampleRange made{1000, 1000 + static_cast<std::size_t>(fraction * static_cast<double>(frozen.size()))};
      std::fill(frozen.begin() + 1000, frozen.begin() + static_cast<std::ptrdiff_t>(made.end), frozen[1000]);
      const std::vector<SampleRange> still = find_stretches(frozen, rate_hz).unmeasured;
      REQUIRE(still.size() == 1);
      CHECK(is_about(still[0], made));
      bridge(bridged, made, step);
      const std::vector<SampleRange> line = find_stretches(bridged, rate_hz).unmeasured;
      REQUIRE(line.size() == 1);
      CHECK(is_about(line[0], made));
      for (std::size_t piece = 0; piece < 10; ++piece) {
        const std::size_t begin = 100 + 1200 * piece;
        bridge(pieces, {begin, begin + made.size() / 10}, step);
      }
      CHECK(find_stretches(pieces, rate_hz).unmeasured.size() == 10);
    }
  }
  // Few wrong samples at both ends of a coarse, quiet sway do not make a line of it.
  std::vector<double> coarse = sway(0.02, 0.2);
  for (const std::size_t at : {std::size_t{5}, coarse.size() - 5}) coarse[at] += 20.0;
  CHECK(find_stretches(coarse, rate_hz).straight.empty());
}

TEST_CASE("a trial knows its gaps: filled on reading, bridged, frozen, and lacking at an end") {
  const sim::Protocol protocol = sim::default_protocol();
  const auto samples = static_cast<std::size_t>(protocol.samples());
  const auto gaps_of = [&](std::vector<double> degrees, double hz, std::vector<SampleRange> filled = {}) {
    for (double& value : degrees) value *= sim::rad_per_deg;
    Recording recording = make_recording(degrees, hz);
    recording.gaps = std::move(filled);
    return bring_to_protocol(recording, protocol).gaps;
  };
  std::vector<double> values = sway(0.02, 0.0, samples);
  CHECK(gaps_of(values, rate_hz).empty());
  CHECK(gaps_of(values, rate_hz, {{500, 504}}).empty());  // too short to matter
  CHECK(gaps_of(values, rate_hz, {{500, 505}}) == std::vector<SampleRange>{{500, 505}});
  bridge(values, {3000, 3200});
  std::fill_n(values.begin() + 5000, 40, values[5000]);
  CHECK(gaps_of(values, rate_hz, {{3100, 3300}}) == std::vector<SampleRange>{{3000, 3300}, {5001, 5040}});
  values.resize(samples - 60);
  CHECK(gaps_of(values, rate_hz).back() == SampleRange{samples - 60, samples});
  // At twice the rate, gaps are in the trial's samples, and one longer at either end.
  std::vector<double> twice;
  for (const double value : sway(0.02, 0.0, samples)) twice.insert(twice.end(), 2, value);
  const std::vector<SampleRange> found = gaps_of(twice, 200.0, {{1000, 1200}});
  REQUIRE(found.size() == 1);
  CHECK(found[0] == SampleRange{499, 601});
}
