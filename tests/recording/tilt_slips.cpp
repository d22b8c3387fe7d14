// Time that is missing in a measured tilt, and clocks that run fast or slowly.
#include "recording/detail/tilt/tilt_slips.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "base/math/random.hpp"
#include "recording/detail/tilt/tilt_start.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

constexpr double rate_hz = 100.0;

const sim::Protocol& protocol() {
  static const sim::Protocol made = sim::default_protocol();
  return made;
}

/// The tilt at the protocol's times plus slip_of(time), with noise.
template <class SlipOf>
std::vector<double> tilt_with(const SlipOf& slip_of, double noise_deg, std::uint64_t item = 0) {
  const std::vector<double> exact = prescribed_tilt(protocol());
  const Random random(4, sim::streams::sensor_noise, item);
  std::vector<double> tilt;
  for (std::size_t k = 0; k < exact.size(); ++k) {
    const double at = static_cast<double>(k) / rate_hz;
    const double place = std::clamp((at + slip_of(at)) * rate_hz, 0.0, static_cast<double>(exact.size() - 1));
    tilt.push_back(exact[static_cast<std::size_t>(std::lround(place))] +
                   noise_deg * sim::rad_per_deg * random.normal(k));
  }
  return tilt;
}

Warnings warned(const std::vector<double>& tilt, bool start_was_given = false,
                const std::vector<SampleRange>& gaps = {}) {
  return look_for_tilt_slips(tilt, gaps, ProtocolPlan(protocol()), rate_hz, start_was_given);
}

}  // namespace

TEST_CASE("a stretch that is missing is named once, where it is, whatever the alignment") {
  for (const double aligned_s : {0.0, -0.15, -0.3}) {  // after the first part, the mean, or the last part
    CAPTURE(aligned_s);
    const Warnings warnings = warned(tilt_with([&](double t) { return aligned_s + (t < 60.0 ? 0.0 : 0.3); }, 0.02));
    REQUIRE(warnings.size() == 1);
    CHECK(warnings[0].code == "time_slips");
    CHECK(contains(warnings[0].text, "missing"));
    CHECK(contains(warnings[0].text, "after about 60"));  // a part of 15.1 s begins at 60.5 s
    CHECK(within(std::stod(warnings[0].text.substr(warnings[0].text.find("tilt is ") + 8)), 0.3, 0.02));
  }
  const Warnings twice = warned(tilt_with([](double t) { return t < 60.0 ? 0.0 : -0.3; }, 0.02));
  REQUIRE(twice.size() == 1);
  CHECK(contains(twice[0].text, "twice"));
  // Another start is not a slip, unless the start was given.
  CHECK(warned(tilt_with([](double) { return 0.2; }, 0.02)).empty());
  CHECK(contains(warned(tilt_with([](double) { return 0.2; }, 0.02), true).front().text, "begin"));
}

TEST_CASE("fewer than 1% of sound tilts are warned of, with noise of 0.02 and of 0.05 degrees") {
  int count = 0;
  for (std::uint64_t item = 0; item < 60; ++item)
    count += warned(tilt_with([](double) { return 0.0; }, item % 2 == 0 ? 0.02 : 0.05, item)).empty() ? 0 : 1;
  CHECK(count == 0);
}

TEST_CASE("parts in gaps of the tilt show no slip") {
  const std::vector<double> tilt = tilt_with([](double t) { return t < 60.0 ? 0.0 : 0.3; }, 0.02);
  CHECK(warned(tilt, false, {{6050, 12100}}).empty());
}

TEST_CASE("a clock that runs fast or slowly is named with the rate") {
  // The slope of the slip: a clock that runs 0.2% fast makes the tilt late by 0.2%.
  for (const double slope : {-0.002, 0.003, -0.003, 0.01}) {
    CAPTURE(slope);
    const Warnings warnings = warned(tilt_with([&](double t) { return slope * (t - 60.0); }, 0.02));
    REQUIRE(warnings.size() == 1);
    CHECK(warnings[0].code == "clock_differs");
    const std::string& found = warnings[0].text;
    INFO(found);
    const double percent = std::stod(found.substr(found.find("runs ") + 5));
    CHECK(within(percent, 100.0 * std::abs(slope), 0.02));
    CHECK(contains(found, slope < 0.0 ? "fast" : "slowly"));
    CHECK(within(std::stod(found.substr(found.find("rate") + 5)), rate_hz / (1.0 + slope), 0.02));
  }
}

TEST_CASE("slips below a sample are none: the tilt of slow samples") {
  for (const double hz : {1.0, 2.0}) {
    CAPTURE(hz);
    sim::Protocol slow;
    slow.experiment.stimulus = sim::Sines{.components = {{.frequency_hz = 0.1, .amplitude_deg = 0.5}}, .cycle_s = 40.0};
    slow.experiment.sample_rate_hz = hz;
    const ProtocolPlan plan(slow);
    std::vector<double> tilt;
    for (std::size_t k = 0; k < plan.tilt_rad().size(); ++k) {
      const double t = (static_cast<double>(k) + (k < plan.tilt_rad().size() / 2 ? 0.0 : -0.4)) / hz;
      tilt.push_back(0.5 * sim::rad_per_deg * std::sin(2.0 * sim::pi * 0.1 * t));
    }
    CHECK(look_for_tilt_slips(tilt, {}, plan, hz, false).empty());
  }
}
