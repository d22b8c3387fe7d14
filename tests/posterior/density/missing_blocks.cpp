// Gaps of a recording: the density integrates their blocks out, and their values do not count; gaps that are refused.
// spectrum.cpp holds the noise of missing blocks to explicit covariance matrices.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "base/error.hpp"
#include "base/math/cholesky.hpp"
#include "posterior/density/density.hpp"
#include "tests/helpers.hpp"
#include "tests/posterior/density/density_points.hpp"
#include "tests/posterior/trial.hpp"

using namespace decid;
using namespace decid::posterior;
using namespace decid::test;

namespace {

/// A gap of 1.35 s and a short one, which touch 14 and 1 blocks of 0.1 s.
const std::vector<SampleRange> gaps{{305, 440}, {700, 703}};

Observation observe_gaps(const Density& density, float shift_rad = 0.0F) {
  std::vector<float> sway = recorded(density.protocol(), some_parameters(), 0.02, 0);
  for (const SampleRange& gap : gaps)
    for (std::size_t i = gap.first; i < gap.end; ++i) sway[i] += shift_rad;
  return density.observe(sway, gaps);
}

}  // namespace

TEST_CASE("Density: gradients with gaps are those of finite differences") {
  const Density density(sines_protocol(), {});
  const Observation observation = observe_gaps(density);
  CHECK(observation.missing.count() == 15);
  CHECK(worst_gradient(density, observation, {}) < 1.0);
  CHECK(worst_gradient(density, observation, 0.05) < 1.0);
}

TEST_CASE("Density: missing blocks have no residual, so the annealing does not take them for noise") {
  const Density density(sines_protocol(), {});
  const Observation observation = observe_gaps(density, 1.0F);
  const Values residual = model(density, observation, random_points(density, 4)).residual;
  for (const int m : observation.missing.blocks)
    for (std::size_t l = 0; l < lanes; ++l) CHECK(residual[static_cast<std::size_t>(m) * lanes + l] == 0.0);
}

// A gap's values, such as zeros of lost samples, would raise the noise of the highest frequencies most.
TEST_CASE("Density: the values in a gap do not count") {
  const Density density(sines_protocol(), {});
  const Observation here = observe_gaps(density),
                    there = observe_gaps(density, static_cast<float>(0.5 * sim::rad_per_deg));
  CHECK(there.noise_deg == here.noise_deg);
  CHECK(there.sway == here.sway);
  CHECK(there.torque == here.torque);
  const Observation whole = density.observe(recorded(density.protocol(), some_parameters(), 0.02, 0));
  CHECK(near(here.noise_deg, whole.noise_deg, 0.15));
}

TEST_CASE("Density: the information with gaps is that of the model's derivatives") {
  const Density density(sines_protocol(), {});
  const int noises = density.noise_size();
  const std::vector<int> some{0, 11, noises - 1, noises, noises + 1, noises + 5, noises + 6, noises + 8, noises + 9};
  CHECK(worst_information(density, observe_gaps(density), random_points(density, 2), some) < 4e-4);
}

TEST_CASE("Density: a workspace serves observations of different gaps") {
  const Density density(sines_protocol(), {});
  const Values x = random_points(density, 2);
  const Observation gapped = observe_gaps(density),
                    whole = density.observe(recorded(density.protocol(), some_parameters(), 0.02, 0));
  const auto size = triangle(static_cast<std::size_t>(density.size())) * lanes;
  Density::Workspace used(density), fresh(density);
  std::vector<double> after(size), alone(size);
  density.information(gapped, x, after, used);
  density.information(whole, x, after, used);
  density.information(whole, x, alone, fresh);
  CHECK(after == alone);
  Values gradient(x.size()), gradient_alone(x.size());
  std::vector<double> potential(lanes), potential_alone(lanes);
  density.evaluate(gapped, x, gradient, potential, used);
  density.evaluate(whole, x, gradient, potential, used);
  density.evaluate(whole, x, gradient_alone, potential_alone, fresh);
  CHECK(gradient == gradient_alone);
  CHECK(potential == potential_alone);
}

TEST_CASE("Density: gaps outside of the recording, gaps that are too long, and a constant recording are refused") {
  const Density density(sines_protocol(), {});
  const std::vector<float> sway = recorded(density.protocol(), some_parameters(), 0.02, 0);
  const auto observe = [&](SampleRange gap) { return density.observe(sway, std::span(&gap, 1)); };
  check_error([&] { observe({5, 5}); }, Code::setting_out_of_range, "recording");
  check_error([&] { observe({0, sway.size() + 1}); }, Code::setting_out_of_range, "recording");
  CHECK(observe({sway.size() - 1, sway.size()}).missing.count() <= 1);
  const Density of_minutes(sim::default_protocol(), {});
  const std::vector<float> longer(static_cast<std::size_t>(of_minutes.protocol().samples()), 0.0F);
  check_error([&] { of_minutes.observe(longer); }, Code::value_invalid);
  CHECK(of_minutes.at_rest().noise_deg == 0.0);
  const std::array<SampleRange, 2> twice{{{100, 1200}, {2000, 3000}}};
  check_error([&] { of_minutes.observe(longer, twice); }, Code::value_missing, "21 s");
  // Half of a short trial; and many short gaps, each of which touches one block of 0.1 s.
  CHECK(observe({0, 1000}).missing.count() == 100);
  check_error([&] { observe({0, 1001}); }, Code::value_missing, "10.1 s");
  std::vector<SampleRange> samples;
  for (std::size_t i = 0; i < 201; ++i) samples.push_back({10 * i, 10 * i + 1});
  check_error([&] { of_minutes.observe(longer, samples); }, Code::value_missing, "20.1 s");
}

TEST_CASE("Density: gaps in any order, which may overlap, are those of their union") {
  const Density density(sines_protocol(), {});
  const std::vector<float> sway = recorded(density.protocol(), some_parameters(), 0.02, 0);
  const std::vector<SampleRange> shuffled{{700, 703}, {400, 440}, {305, 420}, {310, 320}};
  CHECK(density.observe(sway, shuffled).missing.blocks == density.observe(sway, gaps).missing.blocks);
}

TEST_CASE("Density: samples in gaps need not be finite, others must be") {
  const Density density(sines_protocol(), {});
  std::vector<float> sway = recorded(density.protocol(), some_parameters(), 0.02, 0);
  const std::size_t last = sway.size() - 1;
  const std::array<SampleRange, 3> ranges{{{0, 5}, {300, 340}, {last, last + 1}}};
  std::vector<float> lines = sway;
  for (std::size_t i = 0; i < 5; ++i) lines[i] = sway[5];
  for (std::size_t i = 0; i < 40; ++i)
    lines[300 + i] = sway[299] + (sway[340] - sway[299]) / 41.0F * static_cast<float>(i + 1);
  lines[last] = sway[last - 1];
  sway[2] = sway[310] = std::numeric_limits<float>::quiet_NaN();
  sway[last] = std::numeric_limits<float>::infinity();
  const Observation bridged = density.observe(sway, ranges), expected = density.observe(lines, ranges);
  CHECK(bridged.sway == expected.sway);
  CHECK(bridged.torque == expected.torque);
  check_error([&] { density.observe(sway, std::span(ranges).first(2)); }, Code::value_invalid, "1999");
}
