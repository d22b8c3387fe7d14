// Warnings of a posterior: which quantities lean on the end of what is known beforehand.
#include "identify/detail/fit_warnings.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>

#include "tests/helpers.hpp"
#include "tests/posterior/sampling/quick.hpp"
#include "tests/posterior/trial.hpp"

namespace decid {
namespace {

/// Replaces the R-hats of a posterior, the first of its lists of numbers.
struct RhatSetter {
  const std::vector<double>& rhat;
  bool done = false;
  template <class... Fields>
  void operator()(Fields&... fields) {
    (set(fields), ...);
  }
  template <class Field>
  void set(Field&) {}
  void set(std::vector<double>& field) {
    if (!done) field = rhat;
    done = true;
  }
};

/// Replaces the states of a posterior.
struct StateSetter {
  const posterior::State& state;
  template <class... Fields>
  void operator()(Fields&... fields) {
    (set(fields), ...);
  }
  template <class Field>
  void set(Field&) {}
  void set(std::vector<posterior::State>& states) { std::ranges::fill(states, state); }
};

}  // namespace

TEST_CASE("chains: warned of by the parameters' R-hats, with another severity for the network's answer") {
  const sim::Protocol protocol = test::sines_protocol();
  const posterior::Density density(protocol, {});
  const posterior::Observation observation =
      density.observe(test::recorded(protocol, test::some_parameters(), 0.02, 0));
  posterior::Posterior found = posterior::sample(density, observation, test::quick());
  const auto warned = [&](double of_parameter, double of_gain, bool from_network) {
    std::vector<double> rhat(found.rhat().size(), 1.0);
    rhat[sim::Kd] = of_parameter;
    rhat.back() = of_gain;
    RhatSetter set{rhat};
    found.archive(set);
    Warnings chains;
    for (const Warning& one : posterior_warnings(density, observation, found, from_network))
      if (one.code == "chains_disagree" || one.code == "few_draws") chains.push_back(one);
    REQUIRE(chains.size() == 1);  // 20 draws a chain are too few for agreement
    return chains.front();
  };
  const Warning rough = warned(1.5, 1.0, false), gain = warned(1.1, 4.0, false), apart = warned(1.51, 1.0, false);
  CHECK(rough.code == "few_draws");
  CHECK(rough.severity == Severity::info);
  CHECK(test::contains(rough.text, "Kd"));
  CHECK_FALSE(test::contains(rough.text, "gain"));
  CHECK(gain.code == "few_draws");
  CHECK(test::contains(gain.text, "the gain"));
  CHECK(apart.code == "chains_disagree");
  CHECK(apart.severity == Severity::caution);
  CHECK(warned(1.51, 1.0, true).severity == Severity::info);
}

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

TEST_CASE("at_edge: the remedy is the setting of the quantity, and a start at its limit is a caution") {
  const sim::Protocol protocol = test::sines_protocol();
  const posterior::Density density(protocol, {});
  const posterior::Observation observation =
      density.observe(test::recorded(protocol, test::some_parameters(), 0.02, 0));
  posterior::Posterior found = posterior::sample(density, observation, test::quick());
  const AlignedVector<double> middle(static_cast<std::size_t>(density.size()) * posterior::lanes, 0.0);
  const auto warned = [&](const auto& change, bool from_network) {
    posterior::State state = density.state(middle, 0);
    change(state);
    StateSetter set{state};
    found.archive(set);
    Warnings edges;
    for (const Warning& one : posterior_warnings(density, observation, found, from_network))
      if (one.code == "at_edge") edges.push_back(one);
    REQUIRE(edges.size() == 1);
    return edges.front();
  };
  const auto starts_late = [](posterior::State& state) { state.start_s = 0.0999; };
  const Warning start = warned(starts_late, false);
  CHECK(start.severity == Severity::caution);
  CHECK(test::contains(start.text, "prior_start"));
  CHECK_FALSE(test::contains(start.text, "ranges"));
  CHECK(warned(starts_late, true).severity == Severity::info);
  const Warning gain = warned([](posterior::State& state) { state.gain = 1.2; }, false);
  CHECK(gain.severity == Severity::info);
  CHECK(test::contains(gain.text, "prior_gain"));
  const auto stiffest = [&](posterior::State& state) { state.parameters[sim::Kp] = density.ranges()[sim::Kp].high; };
  const Warning parameter = warned(stiffest, false);
  CHECK(parameter.severity == Severity::info);
  CHECK(test::contains(parameter.text, "ranges"));
}

}  // namespace decid
