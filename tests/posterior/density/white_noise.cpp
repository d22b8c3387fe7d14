// Draws of the white noise given all other unknowns have the distribution that the density gives it.
#include <algorithm>
#include <cmath>
#include <vector>

#include "base/error.hpp"
#include "base/math/random.hpp"
#include "posterior/density/density.hpp"
#include "tests/helpers.hpp"
#include "tests/posterior/density/density_points.hpp"
#include "tests/posterior/trial.hpp"

using namespace decid;
using namespace decid::posterior;
using namespace decid::test;

namespace {

struct Draws {
  std::vector<double> normals = std::vector<double>(Density::white_noise_draws * lanes);
  std::vector<double> uniforms = normals;
};

Draws draws(std::uint64_t item) {
  const Random random(5, posterior::streams::chains, item);
  Draws r;
  random.fill_normal(r.normals);
  for (std::size_t i = 0; i < r.uniforms.size(); ++i) r.uniforms[i] = random.uniform(1000 + i);
  return r;
}

/// Returns the distribution function of a chain's white noise coordinate at ascending values, by the density on a grid.
std::vector<double> distribution(const Density& density, const Observation& observation, Values x, int coordinate,
                                 std::size_t chain, const std::vector<double>& values) {
  const double low = values.front() - 1.0, high = values.back() + 1.0, step = 0.004;
  std::vector<double> potential;
  for (double value = low; value < high; value += step) {
    at(x, coordinate, chain) = value;
    potential.push_back(evaluate(density, observation, x).potential[chain]);
  }
  const double least = *std::ranges::min_element(potential);
  std::vector<double> below{0.0};
  for (const double here : potential) below.push_back(below.back() + std::exp(least - here));
  std::vector<double> found;
  for (const double value : values) {
    const double place = (value - low) / step + 0.5;
    const auto cell = static_cast<std::size_t>(place);
    const double part = place - static_cast<double>(cell);
    found.push_back(std::lerp(below[cell], below[cell + 1], part) / below.back());
  }
  return found;
}

}  // namespace

// 300 draws each, whose chains begin far from the distribution, so the first 20 do not count. Draws of eight Metropolis
// steps hardly depend on the last ones. Kolmogorov's distance times the root of 300 exceeds 2.1 by chance once in
// 3,400.
TEST_CASE("draw_white_noise: draws have the distribution of the density, with and without gaps") {
  const sim::Protocol protocol = sines_protocol();
  const Density density(protocol, {});
  const std::vector<float> sway = recorded(protocol, some_parameters(), 0.02, 0);
  const int coordinate = density.noise_size() + static_cast<int>(density.place(Density::sensor_noise));
  for (const std::vector<SampleRange>& gaps : {std::vector<SampleRange>{}, {{305, 340}}}) {
    const Observation observation = density.observe(sway, gaps);
    const Values begin = random_points(density, 8);
    Values x = begin;
    Density::Workspace work(density);
    std::vector<double> found;
    for (std::uint64_t draw = 0; draw < 320; ++draw) {
      const Draws with = draws(draw);
      density.draw_white_noise(observation, x, with.normals, with.uniforms, work);
      if (draw >= 20) found.push_back(at(x, coordinate, 2));
    }
    std::ranges::sort(found);
    const std::vector<double> expected = distribution(density, observation, x, coordinate, 2, found);
    double distance = 0.0;
    const auto count = static_cast<double>(found.size());
    for (std::size_t i = 0; i < found.size(); ++i)
      distance = std::max({distance, std::abs(expected[i] - static_cast<double>(i) / count),
                           std::abs(expected[i] - static_cast<double>(i + 1) / count)});
    CHECK(distance * std::sqrt(count) < 2.1);
    for (std::size_t i = 0; i < x.size(); ++i)
      if (i / lanes != static_cast<std::size_t>(coordinate)) REQUIRE(x[i] == begin[i]);
  }
}

// A Metropolis step is exact only if the way back has the same width.
TEST_CASE("draw_white_noise: a step's width is the same wherever it begins") {
  const Density density(sines_protocol(), {});
  const Observation observation = density.observe(recorded(sines_protocol(), some_parameters(), 0.02, 0));
  const int white = density.noise_size() + static_cast<int>(density.place(Density::sensor_noise)),
            slow = density.noise_size() + static_cast<int>(density.place(Density::slow_noise));
  std::vector<double> steps;
  for (const double begin : {-0.2, 0.0, 0.2})
    for (const double of_slow : {-1.0, 1.5}) {
      Values x = random_points(density, 8);
      for (std::size_t chain = 0; chain < lanes; ++chain) {
        at(x, white, chain) = begin;
        at(x, slow, chain) = of_slow;
      }
      Draws with;
      std::fill_n(with.normals.begin(), lanes, 1.0);  // one step of one width; the others go nowhere
      std::ranges::fill(with.uniforms, 1e-300);       // and are accepted
      Density::Workspace work(density);
      density.draw_white_noise(observation, x, with.normals, with.uniforms, work);
      for (std::size_t chain = 0; chain < lanes; ++chain) steps.push_back(at(x, white, chain) - begin);
    }
  CHECK(steps.front() > 0.01);
  for (const double step : steps) CHECK(near(step, steps.front(), 1e-9));
}

TEST_CASE("draw_white_noise: the same bits for every instruction set, and its errors") {
  const sim::Protocol protocol = sines_protocol();
  const std::vector<float> sway = recorded(protocol, some_parameters(), 0.02, 0);
  const Draws with = draws(1);
  Values first;
  for (const Isa isa : available_isas()) {
    const Density density(protocol, {}, isa);
    Values x = random_points(density, 8);
    Density::Workspace work(density);
    density.draw_white_noise(density.observe(sway), x, with.normals, with.uniforms, work);
    if (first.empty()) first = x;
    CHECK(x == first);
    const std::vector<double> few(lanes);
    check_error([&] { density.draw_white_noise(density.observe(sway), x, few, with.uniforms, work); },
                Code::size_mismatch, "8 results");
  }
}
