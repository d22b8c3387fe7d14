// ResponseRatio: 1 for trials of the controller itself, reversed with them, nothing in noise, and undefined if it
// falls.
#include "identify/response_ratio.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/streams.hpp"
#include "tests/identify/measure_response_ratio.hpp"
#include "tests/near.hpp"

namespace decid {
namespace {

using namespace test;

/// 60 s of tilt of 2 degrees: two cycles of a ternary sequence.
const sim::Simulator& simulator() {
  static const sim::Simulator one([] {
    sim::Protocol protocol = sim::short_protocol();
    protocol.sequence().amplitude_deg = 2.0;
    return protocol;
  }());
  return one;
}

sim::Parameters controller(double nv = 0.2) {
  sim::Parameters parameters = sim::single_pendulum().parameters.middle();
  parameters[sim::Nv] = nv;
  return parameters;
}

/// A trial with sensor noise of 0.02 degrees. Item 1000 and above: those that ResponseRatio itself simulates are
/// others.
std::vector<float> trial(const sim::Parameters& parameters, std::uint64_t item) {
  std::vector<double> sway(static_cast<std::size_t>(simulator().samples()));
  REQUIRE(simulator().run(parameters, Random(3, sim::streams::vestibular_noise, item), sway).valid);
  const Random sensor(3, sim::streams::sensor_noise, item);
  for (std::size_t k = 0; k < sway.size(); ++k) sway[k] += 0.02 * sim::rad_per_deg * sensor.normal(k);
  return {sway.begin(), sway.end()};
}

struct Sample {
  double mean, stddev;
};
template <class Make>
Sample measured(const test::ResponseRatioAlone& ratio, int count, const Make& make) {
  std::vector<double> values;
  double sum = 0, squares = 0;
  for (int i = 0; i < count; ++i) values.push_back(ratio.measure(controller(), make(static_cast<std::uint64_t>(i))));
  for (const double value : values) sum += value;
  for (const double value : values) squares += (value - sum / count) * (value - sum / count);
  return {sum / count, std::sqrt(squares / (count - 1))};
}

constexpr int trials = 24;

}  // namespace

TEST_CASE("response ratio: trials of the controller itself follow by 1, reversed ones by -1") {
  const test::ResponseRatioAlone ratio(simulator());
  const Sample own = measured(ratio, trials, [](auto i) { return trial(controller(), i); });
  // Four standard errors of the mean, one in 16,000; and the response that it is laid over is itself a mean of 32
  // trials: another standard error of 1 / sqrt(32) of a trial's deviation.
  CHECK(own.stddev < 0.1);
  CHECK(within(own.mean, 1.0, 4 * own.stddev * std::sqrt(1.0 / trials + 1.0 / 32)));

  std::vector<float> sway = trial(controller(), 0);
  const double follows = ratio.measure(controller(), sway);
  for (float& value : sway) value = -value;
  CHECK(ratio.measure(controller(), sway) == -follows);
  // An offset is in no line that counts: what is left is its rounding to float.
  for (float& value : sway) value = 0.25F - value;
  CHECK(within(ratio.measure(controller(), sway), follows, 1e-5));
}

TEST_CASE("response ratio: without vestibular noise it is 1 but for the sensor's") {
  const test::ResponseRatioAlone ratio(simulator());
  const std::vector<float> sway = trial(controller(0.0), 0);
  CHECK(within(ratio.measure(controller(0.0), sway), 1.0, 0.01));
  // Half the sway is half the response.
  std::vector<float> half = sway;
  for (float& value : half) value *= 0.5F;
  CHECK(within(ratio.measure(controller(0.0), half), 0.5, 0.01));
}

TEST_CASE("response ratio: where noise drowns the response its mean and deviation are known") {
  sim::Protocol protocol = simulator().protocol();
  protocol.sequence().amplitude_deg = 0.1;
  const sim::Simulator little(protocol);
  const test::ResponseRatioAlone ratio(little);
  ResponseRatio::Spread spread;
  double sum = 0.0, squares = 0.0;
  constexpr int many = 100;
  for (int i = 0; i < many; ++i) {
    std::vector<double> sway(static_cast<std::size_t>(little.samples()));
    REQUIRE(
        little.run(controller(), Random(3, sim::streams::vestibular_noise, static_cast<std::uint64_t>(i)), sway).valid);
    const double value = ratio.measure(controller(), std::vector<float>(sway.begin(), sway.end()), &spread);
    sum += value / many;
    squares += value * value / many;
  }
  CHECK(spread.mean < 0.9);
  // Four standard errors; the response that all are laid over is itself a mean of 32 trials.
  CHECK(within(sum, spread.mean, 4.0 * spread.sd * std::sqrt(1.0 / many + 1.0 / 32)));
  // A deviation of 32 values errs by an eighth of itself, one of 100 by a fourteenth: four of both together.
  CHECK(near(std::sqrt(squares - sum * sum), spread.sd, 0.57));
}

TEST_CASE("response ratio: white noise, sway of another start and of no tilt do not follow") {
  const test::ResponseRatioAlone ratio(simulator());
  const Sample noise = measured(ratio, trials, [](std::uint64_t i) {
    const Random random(9, sim::streams::sensor_noise, i);
    std::vector<float> sway(static_cast<std::size_t>(simulator().samples()));
    for (std::size_t k = 0; k < sway.size(); ++k)
      sway[k] = static_cast<float>(0.5 * sim::rad_per_deg * random.normal(k));
    return sway;
  });
  CHECK(noise.stddev > 0);
  CHECK(noise.stddev < 0.1);
  CHECK(within(noise.mean, 0.0, 4 * noise.stddev / std::sqrt(trials)));

  // Half a cycle late is reversed: a ternary sequence's second half is its first negated. A quarter is neither.
  const auto late = [&](std::ptrdiff_t samples) {
    return measured(ratio, trials,
                    [&](std::uint64_t i) {
                      std::vector<float> sway = trial(controller(), i);
                      std::rotate(sway.begin(), sway.begin() + samples, sway.end());
                      return sway;
                    })
        .mean;
  };
  CHECK(late(1000) < -0.5);
  CHECK(std::abs(late(500)) < 0.3);

  sim::Protocol still = simulator().protocol();
  still.sequence().amplitude_deg = 1e-6;
  const sim::Simulator unmoved(still);
  const Sample quiet = measured(ratio, trials, [&](std::uint64_t i) {
    std::vector<double> sway(static_cast<std::size_t>(unmoved.samples()));
    REQUIRE(unmoved.run(controller(), Random(3, sim::streams::vestibular_noise, i), sway).valid);
    return std::vector<float>(sway.begin(), sway.end());
  });
  CHECK(within(quiet.mean, 0.0, 4 * quiet.stddev / std::sqrt(trials)));
}

TEST_CASE("response ratio: a controller that falls is followed by nobody") {
  const test::ResponseRatioAlone ratio(simulator());
  sim::Parameters falling = controller();
  falling[sim::Kp] = falling[sim::Kp_pass] = 0.0;
  CHECK(std::isnan(ratio.measure(falling, trial(controller(), 0))));
  // Values that a network may give, a little outside: at the nearest that can be simulated.
  sim::Parameters outside = controller();
  outside[sim::Nv] = -0.01;
  outside[sim::Theta] = -1e-4;
  sim::Parameters nearest = outside;
  nearest[sim::Nv] = nearest[sim::Theta] = 0.0;
  const std::vector<float> sway = trial(controller(), 0);
  CHECK(ratio.measure(outside, sway) == ratio.measure(nearest, sway));
  CHECK(sim::single_pendulum().parameters.simulable(outside) == nearest);
  outside[sim::Delay] = 1.5;
  CHECK(sim::single_pendulum().parameters.simulable(outside)[sim::Delay] == sim::longest_delay_s);
  CHECK(sim::single_pendulum().parameters.simulable(controller()) == controller());
}

TEST_CASE("out-of-distribution score: from the distance and the missing response, above 1 beyond the border") {
  CHECK(near(ood_score(1.17 * 2.5, 2.5, 1.0), 1.0, 1e-15));
  CHECK(near(ood_score(0.77 * 2.5, 2.5, 0.0), 1.0, 1e-15));
  CHECK(ood_score(1.0, 1.0, 0.5) > ood_score(1.0, 1.0, 0.6));
  CHECK(ood_score(1.1, 1.0, 0.5) > ood_score(1.0, 1.0, 0.5));
  // Neither more than all nor less than nothing is missing; undefined is all.
  CHECK(ood_score(1.0, 1.0, 3.0) == ood_score(1.0, 1.0, 1.0));
  CHECK(ood_score(1.0, 1.0, -3.0) == ood_score(1.0, 1.0, 0.0));
  CHECK(ood_score(1.0, 1.0, std::numeric_limits<double>::quiet_NaN()) == ood_score(1.0, 1.0, 0.0));
}

}  // namespace decid
