// The pseudo-random ternary sequences, and the stimulus that is made of them.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/protocol/protocol.hpp"
#include "tests/near.hpp"

using namespace decid::sim;
using decid::test::near;

namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

auto occurrences(const std::vector<int>& values, int value) {
  return std::count(values.begin(), values.end(), value);
}

// Highest minus lowest of the accumulated sum.
int divisor(const std::vector<int>& values) {
  int sum = 0, low = 0, high = 0;
  for (const int value : values) {
    sum += value;
    low = std::min(low, sum);
    high = std::max(high, sum);
  }
  return high - low;
}

double peak_to_peak(const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return *high - *low;
}

}  // namespace

TEST_CASE("ternary_sequence: the default sequence") {
  const std::vector<int> values = ternary_sequence(Sequence{});
  REQUIRE(values.size() == 242);
  CHECK(occurrences(values, 0) == 80);
  CHECK(occurrences(values, 1) == 81);
  CHECK(occurrences(values, -1) == 81);
  bool negated = true;
  for (std::size_t i = 0; i < 121; ++i) negated = negated && values[i + 121] == -values[i];
  CHECK(negated);
  CHECK(divisor(values) == 17);
  // By hand, v = (r3 - r4 - r5) mod 3: register 20202 gives 0, 02020 gives 1, 10202 0, 01020 1, 10102 2, 21010 2.
  const std::vector<int> first(values.begin(), values.begin() + 6);
  CHECK(first == std::vector<int>{0, 1, 0, 1, -1, -1});
}

TEST_CASE("make_stimulus: default protocol") {
  const Protocol protocol = default_protocol();
  protocol.validate();
  CHECK(protocol.experiment.steps() == 121'000);
  CHECK(protocol.samples() == 12'100);
  CHECK(protocol.experiment.steps_per_sample() == 10);
  CHECK(protocol.duration_s() == 121.0);
  CHECK(protocol.experiment.cycle_s() == 60.5);

  const Stimulus stimulus = make_stimulus(protocol.experiment);
  const std::vector<double>& tilt = stimulus.tilt_rad;
  REQUIRE(stimulus.interval_steps == 10);
  REQUIRE(tilt.size() == 12'101);
  REQUIRE(stimulus.rate_rad_s.size() == 12'100);
  CHECK(tilt[0] == 0.0);
  CHECK(std::abs(peak_to_peak(tilt) / rad_per_deg - 1.0) < 2.0 * eps);

  CHECK(tilt.back() == 0.0);
  double rate_error = 0.0;
  for (std::size_t k = 0; k < 12'100; ++k)
    rate_error = std::max(rate_error, std::abs((tilt[k + 1] - tilt[k]) * 100.0 - stimulus.rate_rad_s[k]));
  // Tilts are below rad_per_deg and rounded to eps / 2 of it; a difference of two, a hundredfold.
  CHECK(rate_error < 100.0 * eps * rad_per_deg);
}

TEST_CASE("make_stimulus: the trial starts at its offset, 120 ms before a new state") {
  const Protocol protocol = default_protocol();
  const std::vector<int> values = ternary_sequence(protocol.sequence());
  const Stimulus stimulus = make_stimulus(protocol.experiment);
  const double rate = rad_per_deg / 4.25;
  // 25.63 s = 102 states and 130 ms; two cycles of 242 states.
  for (int step = 0; step < 121'000; ++step) {
    const auto state = static_cast<std::size_t>((25'630 + step) / 250 % 242);
    REQUIRE(near(stimulus.rate_at(step), values[state] * rate, 4.0 * eps));  // four roundings each way
  }
  // Where it starts is in the middle of the range, to within a state.
  const auto [low, high] = std::minmax_element(stimulus.tilt_rad.begin(), stimulus.tilt_rad.end());
  CHECK(std::abs(*low + *high) < rad_per_deg / 8.0);
}

TEST_CASE("make_stimulus: short protocol") {
  const Protocol protocol = short_protocol();
  protocol.validate();
  CHECK(protocol.experiment.steps() == 63'700);
  CHECK(protocol.samples() == 6'370);
  CHECK(protocol.experiment.cycle_s() == 20.0);
  const Stimulus stimulus = make_stimulus(protocol.experiment);
  REQUIRE(stimulus.interval_steps == 10);
  CHECK(near(peak_to_peak(stimulus.tilt_rad), rad_per_deg, 2.0 * eps));
  const auto& rate = stimulus.rate_rad_s;
  const auto is_zero = [](double x) { return x == 0.0; };
  CHECK(std::all_of(rate.begin(), rate.begin() + 197, is_zero));
  CHECK(std::all_of(rate.begin() + 6'197, rate.end(), is_zero));
  CHECK(std::all_of(stimulus.tilt_rad.begin(), stimulus.tilt_rad.begin() + 197, is_zero));
  CHECK(std::all_of(stimulus.tilt_rad.begin() + 6'197, stimulus.tilt_rad.end(), is_zero));
  CHECK(std::equal(rate.begin() + 197, rate.begin() + 2'197, rate.begin() + 4'197));
  const std::vector<int> values = ternary_sequence(protocol.sequence());
  for (const std::size_t state : {0u, 1u, 2u, 3u, 79u}) {
    const double expected = values[state] * rad_per_deg / (0.25 * divisor(values));
    CHECK(near(rate[197 + 25 * state], expected, 4.0 * eps));
  }
}

TEST_CASE("make_stimulus: amplitude scales the tilt; rest after the last cycle keeps it") {
  Protocol protocol;
  protocol.sequence().amplitude_deg = 4.0;
  protocol.sequence().cycles = 1;
  protocol.sequence().lead_out_s = 0.5;
  const Stimulus stimulus = make_stimulus(protocol.experiment);
  CHECK(stimulus.tilt_rad.size() == 6'101);
  CHECK(near(peak_to_peak(stimulus.tilt_rad), 4.0 * rad_per_deg, 2.0 * eps));
  CHECK(stimulus.tilt_rad.back() == 0.0);
}

TEST_CASE("Stimulus: between the points of its grid, and a grid as fine as the sequence asks for") {
  Protocol protocol;
  protocol.sequence().offset_s = 25.634;
  protocol.validate();
  const Stimulus fine = make_stimulus(protocol.experiment);
  CHECK(fine.interval_steps == 2);
  protocol.sequence().offset_s = 25.63;
  const Stimulus stimulus = make_stimulus(protocol.experiment);
  // Both play one sequence, 4 ms apart.
  const double first = fine.tilt_at(0), shift = stimulus.tilt_at(4) - first;
  double difference = 0.0;
  for (int step = 0; step < 120'000; step += 7) {
    difference = std::max(difference, std::abs(stimulus.tilt_at(step + 4) - shift - fine.tilt_at(step)));
    CHECK(stimulus.rate_at(step + 4) == fine.rate_at(step));
  }
  CHECK(difference < 4.0 * std::numeric_limits<double>::epsilon() * rad_per_deg);
}
