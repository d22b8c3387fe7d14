// Signals that nobody recorded: the bands of a simulated trial hold the noise, the tilt estimate and the sway that it
// had.
#include "posterior/density/inferred.hpp"

#include <algorithm>
#include <cmath>

#include "base/math/random.hpp"
#include "sim/noise.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"
#include "tests/posterior/trial.hpp"

using namespace decid;
using namespace decid::posterior;
using namespace decid::test;

namespace {

/// Returns the fraction of times at which a value lies in the band.
template <class ValueAt>
double covered(const Band& band, const ValueAt& value_at) {
  double inside = 0.0;
  for (std::size_t i = 0; i < band.low.size(); ++i) {
    const double value = value_at(i);
    inside += band.low[i] <= value && value <= band.high[i] ? 1.0 : 0.0;
    CHECK((band.low[i] <= band.middle[i] && band.middle[i] <= band.high[i]));
  }
  return inside / static_cast<double>(band.low.size());
}

}  // namespace

TEST_CASE("band_of: quantiles at each time") {
  const Band band = make_band(std::vector<double>{0.0, 5.0, 2.0, 5.0, 1.0, 5.0}, 2);  // three draws
  CHECK(band.middle == std::vector<double>{1.0, 5.0});
  CHECK(near(band.low[0], 0.1, 1e-15));
  CHECK(near(band.high[0], 1.9, 1e-15));
  CHECK(band.high[1] == 5.0);
  check_error([] { make_band(std::vector<double>(5), 2); }, Code::size_mismatch, "5 values");
  check_error([] { make_band({}, 2); }, Code::size_mismatch, "0 values");
  check_error([] { make_band(std::vector<double>(5), 0); }, Code::size_mismatch, "0 times");
}

// 90 % of the times if the draws were independent and many; a signal's errors last for seconds, so fewer or more of one
// trial. The noise is that of the simulator: linear between samples, as the density's between its edges.
TEST_CASE("infer: the bands hold what a simulated trial had" * doctest::test_suite("slow")) {
  sim::Protocol protocol = sines_protocol();
  protocol.noise.vestibular.period_s = 40.0;
  const Density density(protocol, {.start_s = 0.0, .gain = 0.0, .standing_s = 0.0});
  const sim::Parameters truth = some_parameters();
  const std::vector<float> sway = recorded(protocol, truth, 0.01, 3);
  const Observation observation = density.observe(sway);
  const Posterior found = sample(density, observation, {.seed = 3, .groups = 2, .min_draws = 30, .max_draws = 30});
  REQUIRE(found.points() > 80);
  const Inferred inferred = infer(density, observation, found);
  REQUIRE(inferred.sway_rad.low.size() == 200);
  REQUIRE(inferred.noise_rad_s.low.size() == 201);
  REQUIRE(inferred.tilt_estimate_rad.low.size() == 201);

  std::vector<double> noise(static_cast<std::size_t>(protocol.samples()) + 1), tilt(noise.size(), 0.0);
  sim::VestibularNoiseMaker(protocol).velocity(truth[sim::Nv], Random(5, sim::streams::vestibular_noise, 3), noise);
  const sim::Stimulus stimulus = sim::make_stimulus(protocol.experiment);
  for (std::size_t k = 1; k < tilt.size(); ++k) {
    tilt[k] = tilt[k - 1];
    for (std::size_t j = 0; j < 10; ++j) {
      const double fraction = 0.1 * static_cast<double>(j);
      const double velocity =
          stimulus.rate_at(static_cast<int>(10 * (k - 1) + j)) + (1.0 - fraction) * noise[k - 1] + fraction * noise[k];
      tilt[k] += sim::integration_step_s * (velocity - std::clamp(velocity, -truth[sim::Theta], truth[sim::Theta]));
    }
  }
  CHECK(covered(inferred.noise_rad_s, [&](std::size_t i) { return noise[10 * i]; }) > 0.75);
  CHECK(covered(inferred.tilt_estimate_rad, [&](std::size_t i) { return tilt[10 * i]; }) > 0.6);
  // The band is of the model's sway, without the sensor's noise: a third of the noise's width, about.
  double error = 0.0, width = 0.0;
  for (std::size_t m = 0; m < 200; ++m) {
    const double line = observation.level_rad + observation.slope_rad * (static_cast<double>(m) - 99.5);
    error += std::pow(inferred.sway_rad.middle[m] - observation.sway[m] - line, 2) / 200.0;
    width += (inferred.sway_rad.high[m] - inferred.sway_rad.low[m]) / 200.0;
  }
  CHECK(std::sqrt(error) < 2.0 * density.block_noise_rad(0.01));
  CHECK(width < 4.0 * density.block_noise_rad(0.01));
  // Half of the coefficients of 200 blocks are looked at, so that a block of white noise of a known level has twice its
  // variance given the others: log p = -log(deviation sqrt(4 pi e)), less half a parameter each.
  const double stddev_deg = density.block_noise_rad(0.01) / sim::rad_per_deg;
  const double known = -200.0 * std::log(stddev_deg * std::sqrt(4.0 * sim::pi * std::exp(1.0)));
  const LeaveOneOut& left_out = inferred.left_out;
  CHECK((left_out.effective_parameters > 7.0 && left_out.effective_parameters < 100.0));
  // Either half of the parameters' cost is out of the data's fit; twice the 100 squares, halved, have a deviation
  // of 14.
  CHECK(within(left_out.log_density + left_out.effective_parameters, known, 80.0));
  CHECK(left_out.log_density < known + 40.0);

  // Points of another density are refused.
  sim::Protocol other = protocol;
  other.noise.vestibular.high_hz = 0.5;
  const Density smaller(other, {});
  check_error([&] { infer(smaller, smaller.observe(sway), found); }, Code::size_mismatch);
}
