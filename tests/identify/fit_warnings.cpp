// Warnings of a posterior: which quantities lean on the end of what is known beforehand.
#include "identify/fit_warnings.hpp"

#include <doctest/doctest.h>

#include <numeric>

#include "tests/posterior/sampling/quick.hpp"
#include "tests/posterior/trial.hpp"

namespace decid {

TEST_CASE("at_edge: of the quantities that are inferred, at either end") {
  const sim::Protocol protocol = test::sines_protocol();
  const std::vector<float> sway = test::recorded(protocol, test::some_parameters(), 0.02, 0);
  const auto edges = [&](const posterior::Priors& priors, double probability) {
    const posterior::Density density(protocol, priors);
    return at_edge(density, posterior::sample(density, density.observe(sway), test::quick()), probability);
  };
  // Each draw is in the lower or in the upper half.
  std::vector<int> all(sim::Delay + 1);
  std::iota(all.begin(), all.end(), 0);
  for (const int quantity : {posterior::Density::sensor_noise, posterior::Density::start, posterior::Density::gain})
    all.push_back(quantity);
  CHECK(edges({}, 0.5) == all);
  std::vector<int> but_known = all;
  std::erase(but_known, int{posterior::Density::start});
  std::erase(but_known, int{posterior::Density::gain});
  CHECK(edges({.start_s = 0.0, .gain = 0.0}, 0.5) == but_known);
  CHECK(edges({}, 1e-9).empty());
}

}  // namespace decid
