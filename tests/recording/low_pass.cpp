// Low-passes of recordings: found where one was, none where none was, and undone.
#include "recording/low_pass.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "base/math/random.hpp"
#include "base/math/statistics.hpp"
#include "sim/protocol/conditions.hpp"
#include "sim/protocol/protocol.hpp"
#include "sim/simulate.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

constexpr double rate_hz = 100.0;

sim::Protocol standing(double sensor_noise_deg) {
  sim::Protocol protocol = sim::default_protocol();
  protocol.standing_s = 10.0;
  protocol.noise.sensor = {sensor_noise_deg, sensor_noise_deg};
  return protocol;
}

/// Returns a simulated sway behind a low-pass of sim::record(), which draws order and direction; 0 Hz: none.
std::vector<float> recorded(double sensor_noise_deg, double cutoff_hz, std::uint64_t item) {
  sim::Protocol protocol = standing(sensor_noise_deg);
  if (cutoff_hz > 0.0) protocol.conditions[sim::Condition::low_pass] = {1.0, cutoff_hz, cutoff_hz};
  const sim::Simulator simulator(protocol.ideal());
  std::vector<double> sway(static_cast<std::size_t>(protocol.samples()));
  simulator.run(simulator.protocol().parameters().middle(), Random(1, sim::streams::vestibular_noise, item), sway);
  sim::record(protocol, 1, item, sway);
  return {sway.begin(), sway.end()};
}

std::vector<double> in_double(const std::vector<float>& sway) {
  return {sway.begin(), sway.end()};
}

double rms(const std::vector<float>& a, const std::vector<float>& b, std::size_t margin) {
  double squares = 0.0;
  for (std::size_t k = margin; k + margin < a.size(); ++k) squares += std::pow(double{a[k]} - double{b[k]}, 2);
  return std::sqrt(squares / static_cast<double>(a.size() - 2 * margin));
}

/// Runs a Butterworth low-pass of order 1, 2 or 4.
std::vector<double> filtered(std::vector<double> sway, int order, bool both_ways, double cutoff_hz,
                             double at_hz = rate_hz) {
  const double warped = std::tan(sim::pi * cutoff_hz / at_hz), square = warped * warped;
  std::vector<double> dampings{std::sqrt(2.0)};
  if (order == 4) dampings = {0.7653668647301795, 1.8477590650225735};  // 2 sin(pi / 8), 2 cos(pi / 8)
  for (int pass = 0; pass < (both_ways ? 2 : 1); ++pass) {
    for (const double damping : dampings) {
      const double middle = damping * warped;
      double in1 = sway[0], in2 = in1, out1 = in1, out2 = in1;
      for (double& value : sway) {
        const double in = value;
        value = order == 1
                    ? (warped * (in + in1) + (1.0 - warped) * out1) / (1.0 + warped)
                    : (square * (in + 2.0 * in1 + in2) + 2.0 * (1.0 - square) * out1 - (1.0 - middle + square) * out2) /
                          (1.0 + middle + square);
        in2 = std::exchange(in1, in);
        out2 = std::exchange(out1, value);
      }
    }
    if (both_ways) std::ranges::reverse(sway);
  }
  return sway;
}

}  // namespace

TEST_CASE("a Butterworth low-pass has the gain and the delay of its definition") {
  for (const int order : {1, 2, 3, 4}) {
    CAPTURE(order);
    const LowPass once{order, false, 5.0, rate_hz}, twice{order, true, 5.0, rate_hz};
    CHECK(once.gain_at(0.0) == 1.0);
    CHECK(near(once.gain_at(5.0), std::sqrt(0.5), 1e-12));
    CHECK(near(twice.gain_at(5.0), 0.5, 1e-12));
    const double ratio = std::tan(sim::pi * 2.5 / rate_hz) / std::tan(sim::pi * 5.0 / rate_hz);
    CHECK(near(once.gain_at(2.5), 1.0 / std::sqrt(1.0 + std::pow(ratio, 2 * order)), 1e-12));
    CHECK(twice.delay_s() == 0.0);
  }
  // Group delays of the analogue prototypes at 0, over the cutoff's period / 2 pi: 1, sqrt 2, 2, 2.6131.
  const double unit_s = 1.0 / (2.0 * sim::pi * 5.0);
  CHECK(near(LowPass{1, false, 5.0, rate_hz}.delay_s(), unit_s, 1e-12));
  CHECK(near(LowPass{2, false, 5.0, rate_hz}.delay_s(), std::sqrt(2.0) * unit_s, 1e-12));
  CHECK(near(LowPass{3, false, 5.0, rate_hz}.delay_s(), 2.0 * unit_s, 1e-12));
  CHECK(near(LowPass{4, false, 5.0, rate_hz}.delay_s(), 2.613125929752753 * unit_s, 1e-12));
}

TEST_CASE("a low-pass is found, and undone it gives the sway before it") {
  // Trials whose filters are of different kinds; a filter of 12 Hz of order 4 changes nothing below 2.5 Hz but a delay.
  int found = 0;
  for (const double noise_deg : {0.005, 0.02, 0.1}) {
    for (const double cutoff_hz : {4.0, 6.0}) {
      for (std::uint64_t item = 0; item < 3; ++item) {
        CAPTURE(noise_deg);
        CAPTURE(cutoff_hz);
        CAPTURE(item);
        const std::vector<float> before = recorded(noise_deg, 0.0, item), sway = recorded(noise_deg, cutoff_hz, item);
        const std::optional<LowPass> filter = find_low_pass(in_double(sway), rate_hz);
        if (!filter) continue;
        ++found;
        CHECK(near(filter->cutoff_hz, cutoff_hz, 0.3));
        CHECK(filter->gain_low <= filter->gain_at(low_pass_hz));
        CHECK(filter->gain_at(low_pass_hz) <= filter->gain_high);
        if (!can_undo(*filter) || filter->delay_s() > 0.0) continue;
        // Averaged to 300 ms: fits ignore what is above 2.5 Hz.
        const auto blocks = [](const std::vector<float>& values) {
          std::vector<float> means;
          for (std::size_t k = 0; k + 30 <= values.size(); k += 30) {
            double sum = 0.0;
            for (std::size_t i = k; i < k + 30; ++i) sum += double{values[i]};
            means.push_back(static_cast<float>(sum / 30.0));
          }
          return means;
        };
        const double left = rms(blocks(undo(*filter, sway, rate_hz)), blocks(before), 10);
        CHECK(left < 0.5 * std::max(rms(blocks(sway), blocks(before), 10), 0.1 * noise_deg * sim::rad_per_deg));
      }
    }
  }
  CHECK(found >= 15);
}

TEST_CASE("a moving average has the gain and the delay of its definition, and undone it gives the sway before it") {
  const LowPass ten = moving_average(10, rate_hz);
  CHECK(ten.order == 0);
  CHECK(ten.gain_at(0.0) == 1.0);
  CHECK(near(ten.gain_at(5.0), std::abs(std::sin(0.5 * sim::pi) / (10.0 * std::sin(0.05 * sim::pi))), 1e-12));
  CHECK(within(ten.gain_at(10.0), 0.0, 1e-15));
  CHECK(near(moving_average(100, rate_hz).gain_at(moving_average(100, rate_hz).cutoff_hz), std::sqrt(0.5), 1e-3));
  CHECK(near(ten.delay_s(), 0.045, 1e-12));
  CHECK(ten.gain_low == ten.gain_at(low_pass_hz));
  CHECK(can_undo(ten));
  for (const int samples : {11, 25}) {
    CAPTURE(samples);
    const std::vector<float> before = recorded(0.005, 0.0, 0);
    std::vector<float> sway(before.size());
    for (std::size_t k = 0; k < sway.size(); ++k) {  // centred
      double sum = 0.0;
      for (int i = 0; i < samples; ++i) {
        const auto at = static_cast<std::ptrdiff_t>(k) + i - samples / 2;
        sum += double{before[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(at, 0, std::ssize(before) - 1))]};
      }
      sway[k] = static_cast<float>(sum / samples);
    }
    const auto slow = [](const std::vector<float>& values) {  // fits ignore what is above 2.5 Hz
      std::vector<float> means;
      for (std::size_t k = 0; k + 30 <= values.size(); k += 30)
        means.push_back(static_cast<float>(mean(std::span(values).subspan(k, 30))));
      return means;
    };
    const std::vector<float> undone = undo(moving_average(samples, rate_hz), sway, rate_hz);
    CHECK(rms(slow(undone), slow(before), 10) < 0.5 * rms(slow(sway), slow(before), 10));
  }
}

TEST_CASE("samples beside a gap are left out after undoing a low-pass, which rings there") {
  for (std::uint64_t item = 0; item < 4; ++item)
    for (const double cutoff_hz : {3.0, 4.0, 6.0}) {
      CAPTURE(item);
      CAPTURE(cutoff_hz);
      const LowPass filter{2, true, cutoff_hz, rate_hz};
      const std::vector<double> smooth = filtered(in_double(recorded(0.02, 0.0, item)), 2, true, cutoff_hz);
      const std::vector<float> whole(smooth.begin(), smooth.end());
      std::vector<float> bridged = whole;
      const SampleRange gap{2000, 3000};
      bridge(bridged, gap);
      const std::vector<float> expected = undo(filter, whole, rate_hz), undone = undo(filter, bridged, rate_hz);
      const std::vector<SampleRange> left_out = gaps_after_undo(filter, std::span(&gap, 1), rate_hz, whole.size());
      REQUIRE(left_out.size() == 1);
      const auto largest = [&](std::size_t first, std::size_t end) {
        double most = 0.0;
        for (std::size_t k = first; k < end; ++k)
          most = std::max(most, std::abs(double{undone[k]} - double{expected[k]}));
        return most / sim::rad_per_deg;
      };
      const double beside = std::max(largest(left_out[0].first, gap.first), largest(gap.end, left_out[0].end));
      const double outside = std::max(largest(0, left_out[0].first), largest(left_out[0].end, whole.size()));
      CHECK(outside < 0.02);  // degrees, a standard deviation of the noise
      CHECK(beside > 3.0 * outside);
    }
  // At the ends of the recording, and where two gaps meet.
  const LowPass filter{2, true, 4.0, rate_hz};
  const std::vector<SampleRange> gaps{{10, 50}, {90, 120}, {980, 1000}};
  CHECK(gaps_after_undo(filter, gaps, rate_hz, 1000) == std::vector<SampleRange>{{0, 145}, {955, 1000}});
}

TEST_CASE("a low-pass is found at high rates, with its cutoff") {
  for (const double at_hz : {500.0, 2000.0}) {
    const Random random(8, sim::streams::sensor_noise, 0);
    std::vector<double> sway(static_cast<std::size_t>(120.0 * at_hz));
    for (std::size_t k = 0; k < sway.size(); ++k) {
      const double t = static_cast<double>(k) / at_hz;
      const double degrees = std::sin(1.3 * t) + 0.3 * std::sin(4.1 * t) + 0.1 * random.normal(k);
      sway[k] = sim::rad_per_deg * degrees;
    }
    CHECK(!find_low_pass(sway, at_hz));
    for (const double cutoff_hz : {4.8, 7.1, 10.6}) {
      CAPTURE(at_hz);
      CAPTURE(cutoff_hz);
      const std::optional<LowPass> filter = find_low_pass(filtered(sway, 4, false, cutoff_hz, at_hz), at_hz);
      REQUIRE(filter);
      CHECK(filter->order == 4);
      CHECK(!filter->both_ways);
      CHECK(near(filter->cutoff_hz, cutoff_hz, 0.05));
      CHECK(can_undo(*filter));
    }
  }
}

TEST_CASE("a low-pass below the band of the noise leaves its gain open, and is not undone") {
  struct Case {
    int order;
    bool both_ways;
    double cutoff_hz;
  };
  for (std::uint64_t item = 0; item < 3; ++item) {
    const std::vector<double> before = in_double(recorded(0.02, 0.0, item));
    for (const Case& of : {Case{1, false, 1.0}, Case{1, false, 1.5}, Case{1, true, 1.0}, Case{2, true, 0.85}}) {
      CAPTURE(item);
      CAPTURE(of.order);
      CAPTURE(of.both_ways);
      CAPTURE(of.cutoff_hz);
      const std::vector<double> sway = filtered(before, of.order, of.both_ways, of.cutoff_hz);
      const std::optional<LowPass> filter = find_low_pass(sway, rate_hz);
      REQUIRE(filter);
      const double gain = LowPass{of.order, of.both_ways, of.cutoff_hz, rate_hz}.gain_at(low_pass_hz);
      CHECK(filter->gain_low <= gain + 0.1);  // noise moves the ends of the range
      CHECK(filter->gain_high >= gain);
      CHECK(!can_undo(*filter));
      CHECK(removes_much(*filter));
    }
  }
}

TEST_CASE("sway without a low-pass has none: noise, slow noise, rounding, steps, gaps, linear interpolation") {
  const Random random(5, sim::streams::sensor_noise, 0);
  for (const double noise_deg : {0.0, 0.001, 0.02, 0.1}) {
    for (std::uint64_t item = 0; item < 3; ++item) {
      CAPTURE(noise_deg);
      CAPTURE(item);
      const std::vector<double> sway = in_double(recorded(noise_deg, 0.0, item));
      CHECK(!find_low_pass(sway, rate_hz));
      for (const double step_deg : {1e-3, 0.1}) {
        std::vector<double> rounded = sway;
        for (double& value : rounded)
          value = step_deg * sim::rad_per_deg * std::round(value / (step_deg * sim::rad_per_deg));
        CHECK(!find_low_pass(rounded, rate_hz));
      }
      for (const double memory_s : {0.05, 0.5, 5.0}) {
        std::vector<double> slow = sway;
        const double kept = std::exp(-1.0 / (memory_s * rate_hz)), fresh = std::sqrt(1.0 - kept * kept);
        double noise = 0.0;
        for (std::size_t k = 0; k < slow.size(); ++k) {
          noise = kept * noise + fresh * random.normal(k);
          slow[k] += 0.05 * sim::rad_per_deg * noise;
        }
        // Noise of 0.05 s with nothing else is that of a first-order filter.
        if (memory_s > 0.1 || noise_deg > 0.01) CHECK(!find_low_pass(slow, rate_hz));
      }
      std::vector<double> bridged = sway;
      for (std::size_t k = 1; k < 200; ++k)
        bridged[4000 + k] = sway[4000] + (sway[4200] - sway[4000]) * static_cast<double>(k) / 200.0;
      CHECK(!find_low_pass(bridged, rate_hz));
    }
  }
  CHECK(!find_low_pass({}, rate_hz));
  CHECK(undo(LowPass{2, true, 5.0, rate_hz}, {}, rate_hz).empty());
  CHECK(!find_low_pass(std::vector<double>(100, 0.5), rate_hz));
  CHECK(!find_low_pass(std::vector<double>(12000, 0.5), rate_hz));
  CHECK(!find_low_pass(in_double(recorded(0.02, 5.0, 0)), 15.0));
}

TEST_CASE("a low-pass whose gain is uncertain or small cannot be undone, and removes much below 0.7") {
  LowPass filter{2, true, 5.0, rate_hz};
  filter.gain_low = filter.gain_high = 0.9;
  CHECK(can_undo(filter));
  filter.gain_low = 0.8;
  CHECK(!can_undo(filter));
  filter.gain_low = filter.gain_high = 0.05;
  CHECK(!can_undo(filter));
  filter.gain_low = filter.gain_high = filter.gain_at(low_pass_hz);
  CHECK(!removes_much(filter));
  filter.gain_low -= 0.2;
  CHECK(removes_much(filter));
  filter.cutoff_hz = 3.0;
  filter.gain_low = filter.gain_high = filter.gain_at(low_pass_hz);
  CHECK(can_undo(filter));
  CHECK(removes_much(filter));
}
