// Warnings of a posterior: which quantities lean on the end of what is known beforehand.
#include "identify/detail/fit_warnings.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "identify/result.hpp"
#include "tests/helpers.hpp"
#include "tests/posterior/sampling/quick.hpp"
#include "tests/posterior/sampling/set_posterior.hpp"
#include "tests/posterior/trial.hpp"

namespace decid {

TEST_CASE("draws with which the body falls are a caution from a twentieth of the simulated trials on") {
  for (const auto& [standing, count] : {std::pair(400, 0), {380, 0}, {379, 1}, {0, 1}}) {
    PredictiveCheck check;
    check.standing = standing;
    const Warnings found = falling_warnings(check);
    REQUIRE(found.size() == static_cast<std::size_t>(count));
    if (count > 0) CHECK(found[0].code == "draws_fall");
    if (count > 0) CHECK(found[0].severity == Severity::caution);
  }
}

TEST_CASE("warnings of a posterior: quantities at the end of their priors, and chains by their R-hats") {
  const sim::Protocol protocol = test::sines_protocol();
  const std::vector<float> sway = test::recorded(protocol, test::some_parameters(), 0.02, 0);
  const posterior::Density density(protocol, {});
  const posterior::Observation observation = density.observe(sway);
  posterior::Posterior found = posterior::sample(density, observation, test::quick());
  const auto warning_of = [&](const std::vector<std::string>& codes, NetworkUse network) {
    Warnings chosen;
    for (const Warning& one : posterior_warnings(density, observation, found, network))
      if (std::ranges::count(codes, one.code) > 0) chosen.push_back(one);
    REQUIRE(chosen.size() == 1);
    return chosen.front();
  };

  // At either end of the quantities that are inferred: each draw is in the lower or in the upper half.
  std::vector<int> all(sim::Delay + 1);
  std::iota(all.begin(), all.end(), 0);
  all.push_back(posterior::Density::sensor_noise);
  const posterior::Density known(protocol, {.start_s = 0.0, .gain = 0.0});
  CHECK(at_edge(known, posterior::sample(known, known.observe(sway), test::quick()), 0.5) == all);
  for (const int quantity : {posterior::Density::start, posterior::Density::gain}) all.push_back(quantity);
  CHECK(at_edge(density, found, 0.5) == all);
  CHECK(at_edge(density, found, 1e-9).empty());

  // Chains: by the parameters' R-hats, with another severity for the network's answer.
  const auto of_chains = [&](double of_parameter, double of_gain, NetworkUse network) {
    std::vector<double> rhat(found.rhat().size(), 1.0);
    rhat[sim::Kd] = of_parameter;
    rhat.back() = of_gain;
    test::set_posterior(found, {found.states().begin(), found.states().end()}, rhat, found.effective_draws());
    return warning_of({"chains_disagree", "few_draws"}, network);  // 20 draws a chain are too few for agreement
  };
  const Warning rough = of_chains(1.5, 1.0, NetworkUse::beside), with_gain = of_chains(1.1, 4.0, NetworkUse::beside),
                apart = of_chains(1.51, 1.0, NetworkUse::beside);
  CHECK(rough.code == "few_draws");
  CHECK(rough.severity == Severity::info);
  CHECK(test::contains(rough.text, "Kd"));
  CHECK_FALSE(test::contains(rough.text, "gain"));
  CHECK(with_gain.code == "few_draws");
  CHECK(test::contains(with_gain.text, "the gain"));
  CHECK(apart.code == "chains_disagree");
  CHECK(apart.severity == Severity::caution);
  CHECK(of_chains(1.51, 1.0, NetworkUse::answers).severity == Severity::info);
  // Without a network smaller distances are a caution.
  CHECK(of_chains(1.1, 1.0, NetworkUse::none).code == "few_draws");
  const Warning alone = of_chains(1.11, 1.0, NetworkUse::none);
  CHECK(alone.code == "chains_disagree");
  CHECK(alone.severity == Severity::caution);

  // The remedy of an end is the setting of the quantity, and a start at its limit is a caution.
  const AlignedVector<double> middle(static_cast<std::size_t>(density.size()) * posterior::lanes, 0.0);
  const auto of_edges = [&](const auto& change, NetworkUse network) {
    posterior::State state = density.state(middle, 0);
    change(state);
    test::set_posterior(found, std::vector(found.states().size(), state), found.rhat(), found.effective_draws());
    return warning_of({"at_edge"}, network);
  };
  const auto starts_late = [](posterior::State& state) { state.start_s = 0.0999; };
  const Warning start = of_edges(starts_late, NetworkUse::beside);
  CHECK(start.severity == Severity::caution);
  CHECK(test::contains(start.text, "prior_start"));
  CHECK_FALSE(test::contains(start.text, "ranges"));
  CHECK(of_edges(starts_late, NetworkUse::answers).severity == Severity::info);
  const Warning gain = of_edges([](posterior::State& state) { state.gain = 1.15; }, NetworkUse::beside);
  CHECK(gain.severity == Severity::info);
  CHECK(test::contains(gain.text, "prior_gain"));
  const auto stiffest = [&](posterior::State& state) { state.parameters[sim::Kp] = density.ranges()[sim::Kp].high; };
  const Warning parameter = of_edges(stiffest, NetworkUse::beside);
  CHECK(parameter.severity == Severity::info);
  CHECK(test::contains(parameter.text, "ranges"));

  // No response to the tilt: the more quantities are at an end, the more severe. Another start explains the sway.
  const auto severities_without_response = [&](recording::Trial trial) {
    std::vector<Severity> severities;
    posterior::State state = density.state(middle, 0);
    for (const int end : {-1, static_cast<int>(sim::Kp), static_cast<int>(sim::Kd)}) {
      if (end >= 0)
        state.parameters[static_cast<std::size_t>(end)] = density.ranges()[static_cast<std::size_t>(end)].high;
      test::set_posterior(found, std::vector(found.states().size(), state), found.rhat(), found.effective_draws());
      for (const Warning& one : tilt_warnings(density, found, trial)) {
        CHECK(one.code == "tilt_not_followed");
        severities.push_back(one.severity);
      }
    }
    return severities;
  };
  recording::Trial trial;
  CHECK(severities_without_response(trial).empty());
  trial.response_gain = 20.0;
  CHECK(severities_without_response(trial) == std::vector{Severity::info, Severity::caution, Severity::invalid});
  trial.response_gain = 27.0;
  CHECK(severities_without_response(trial) == std::vector{Severity::invalid});
  trial.response_gain = 29.0;
  CHECK(severities_without_response(trial).empty());
  // A measured tilt shows that the platform played this stimulus. A start at its end is no sign of another one.
  const auto text_of = [&](const recording::Trial& one) {
    const Warnings warnings = tilt_warnings(density, found, one);
    REQUIRE(warnings.size() == 1);
    return warnings.front().text;
  };
  trial.response_gain = 20.0;
  CHECK(test::contains(text_of(trial), "protocol"));
  CHECK(test::contains(text_of(trial), "begin"));
  trial.tilt.emplace();
  CHECK(test::contains(text_of(trial), "column"));
  CHECK_FALSE(test::contains(text_of(trial), "begin"));
  posterior::State late = density.state(middle, 0);
  late.start_s = 0.0999;
  test::set_posterior(found, std::vector(found.states().size(), late), found.rhat(), found.effective_draws());
  CHECK(tilt_warnings(density, found, trial).front().severity == Severity::info);
  trial.other_start_s = 1.0;
  CHECK(severities_without_response(trial).empty());
}

TEST_CASE("warnings of a posterior: several ends, divergences, and noise that the recording does not have") {
  const sim::Protocol protocol = test::sines_protocol();
  const posterior::Density density(protocol, {});
  const posterior::Observation observation =
      density.observe(test::recorded(protocol, test::some_parameters(), 0.02, 0));
  posterior::Posterior found = posterior::sample(density, observation, test::quick());
  const AlignedVector<double> middle(static_cast<std::size_t>(density.size()) * posterior::lanes, 0.0);
  const posterior::State usual = [&] {
    posterior::State state = density.state(middle, 0);
    state.sensor_noise_deg = 0.02;
    state.slow_noise_deg = 0.001;
    return state;
  }();
  // The severity of a code for draws that are all this state, or nothing.
  const auto severity = [&](const std::string& code, const posterior::State& state, int divergences,
                            NetworkUse network) -> std::optional<Severity> {
    test::set_posterior(found, std::vector(found.states().size(), state), found.rhat(), found.effective_draws(),
                        divergences);
    for (const Warning& one : posterior_warnings(density, observation, found, network))
      if (one.code == code) return one.severity;
    return {};
  };

  // Two parameters at the last of their ranges are a caution, four are refused, also beside a network's answer.
  posterior::State at_ends = usual;
  const auto to_end = [&](std::size_t p) { at_ends.parameters[p] = density.ranges()[p].high; };
  CHECK_FALSE(severity("at_edge", usual, 0, NetworkUse::beside));
  to_end(sim::Kp);
  to_end(sim::Kd);
  CHECK(severity("at_edge", at_ends, 0, NetworkUse::beside) == Severity::caution);
  CHECK(severity("at_edge", at_ends, 0, NetworkUse::answers) == Severity::info);
  to_end(sim::Kp_pass);
  CHECK(severity("at_edge", at_ends, 0, NetworkUse::none) == Severity::caution);
  to_end(sim::Kd_pass);
  for (const NetworkUse network : {NetworkUse::none, NetworkUse::beside, NetworkUse::answers})
    CHECK(severity("at_edge", at_ends, 0, network) == Severity::invalid);

  // A normal prior that the draws are far from.
  const double kp = usual.parameters[sim::Kp];
  const auto contradicts = [&](double sds) {
    const posterior::Density with_prior(
        protocol, {.parameters = {{.name = "Kp", .normal = posterior::ParameterPrior::Normal{kp + sds * 10.0, 10.0}}}});
    test::set_posterior(found, std::vector(found.states().size(), usual), found.rhat(), found.effective_draws());
    const Warnings warnings = posterior_warnings(with_prior, observation, found, NetworkUse::none);
    const auto warning = std::ranges::find(warnings, "prior_contradicted", &Warning::code);
    return warning != warnings.end() && warning->severity == Severity::caution;
  };
  CHECK_FALSE(contradicts(4.9));
  CHECK(contradicts(5.1));
  CHECK(contradicts(-5.1));

  // Divergences: above 5% of the transitions, and only where the draws are the answer.
  const int few = found.draws() / 20;
  CHECK_FALSE(severity("divergences", usual, few, NetworkUse::beside));
  CHECK(severity("divergences", usual, few + 1, NetworkUse::beside) == Severity::caution);
  CHECK_FALSE(severity("divergences", usual, few + 1, NetworkUse::answers));

  // A scale beyond 2.5 standard deviations of its prior, in either direction, is a caution instead of an end of the
  // prior. It counts as an end where others are, and a known gain has no prior.
  const auto of_scale = [&](double gain) {
    posterior::State state = usual;
    state.gain = gain;
    return state;
  };
  for (const double sign : {-1.0, 1.0}) {
    const posterior::State likely = of_scale(std::exp(sign * 2.4 * 0.06)),
                           unlikely = of_scale(std::exp(sign * 2.6 * 0.06));
    for (const NetworkUse network : {NetworkUse::none, NetworkUse::beside, NetworkUse::answers}) {
      CHECK_FALSE(severity("scale_unlikely", likely, 0, network));
      CHECK(severity("at_edge", likely, 0, network) == Severity::info);
      CHECK(severity("scale_unlikely", unlikely, 0, network) == Severity::caution);
      CHECK_FALSE(severity("at_edge", unlikely, 0, network));
    }
  }
  posterior::State three_and_gain = at_ends;
  three_and_gain.parameters[sim::Kd_pass] = usual.parameters[sim::Kd_pass];
  three_and_gain.gain = 1.36;
  CHECK(severity("at_edge", three_and_gain, 0, NetworkUse::none) == Severity::invalid);
  test::set_posterior(found, std::vector(found.states().size(), three_and_gain), found.rhat(), found.effective_draws());
  const Warnings first = posterior_warnings(density, observation, found, NetworkUse::none);
  CHECK(first.front().code == "scale_unlikely");
  CHECK(test::contains(first.front().text, "1.36"));
  const posterior::Density known(protocol, {.gain = 0.0});
  posterior::Posterior of_known = posterior::sample(known, observation, test::quick());
  for (const Warning& one : posterior_warnings(known, observation, of_known, NetworkUse::none))
    CHECK(one.code != "scale_unlikely");

  // Noise: white of at most the model's own error; white far above that of the highest frequencies; a slow one of more
  // than half of the sway.
  double squares = 0.0;
  for (const double sway : observation.sway) squares += sway * sway;
  const double sway_deg = std::sqrt(squares / static_cast<double>(observation.sway.size())) / sim::rad_per_deg;
  const auto with_noise = [&](double white_deg, double slow_deg) {
    posterior::State state = usual;
    state.sensor_noise_deg = white_deg;
    state.slow_noise_deg = slow_deg;
    return state;
  };
  CHECK(severity("little_noise", with_noise(0.0019, 0.001), 0, NetworkUse::beside) == Severity::caution);
  CHECK_FALSE(severity("little_noise", with_noise(0.0021, 0.001), 0, NetworkUse::beside));
  CHECK(test::near(observation.noise_deg, 0.02, 0.1));
  CHECK(severity("unexplained_sway", with_noise(3.1 * observation.noise_deg, 0.001), 0, NetworkUse::beside) ==
        Severity::caution);
  CHECK_FALSE(severity("unexplained_sway", with_noise(2.9 * observation.noise_deg, 0.001), 0, NetworkUse::beside));
  CHECK(severity("unexplained_sway", with_noise(0.02, 0.51 * sway_deg), 0, NetworkUse::beside) == Severity::caution);
  CHECK_FALSE(severity("unexplained_sway", with_noise(0.02, 0.49 * sway_deg), 0, NetworkUse::beside));
}

TEST_CASE("warnings of a fit: an unfollowed tilt that nothing explains is refused; cautions of reading are last") {
  const auto severity_of_tilt = [](const std::vector<std::string>& codes) {
    Warnings warnings;
    add_info(warnings, "tilt_not_followed", "text");
    for (const std::string& code : codes) add_caution(warnings, code, "text");
    warnings = refuse_unexplained(warnings);
    CHECK(warnings.size() == codes.size() + 1);
    return warnings.front().severity;
  };
  CHECK(severity_of_tilt({"out_of_distribution", "unexplained_sway"}) == Severity::invalid);
  CHECK(severity_of_tilt({"unlike_simulated", "out_of_distribution"}) == Severity::invalid);
  CHECK(severity_of_tilt({"out_of_distribution"}) == Severity::info);
  CHECK(severity_of_tilt({"unexplained_sway", "unlike_simulated"}) == Severity::info);

  Warnings read, judged;
  add_caution(read, "part_not_used", "text");
  add_info(read, "unit_assumed", "text");
  add_caution(judged, "tilt_not_followed", "text");
  add_caution(judged, "scale_unlikely", "text");
  add_invalid(judged, "out_of_distribution", "text");
  std::vector<std::string> order;
  for (const Warning& one : most_severe_first({read, judged})) order.push_back(one.code);
  CHECK(order == std::vector<std::string>{"out_of_distribution", "scale_unlikely", "tilt_not_followed", "part_not_used",
                                          "unit_assumed"});
}

TEST_CASE("a network that contradicts the posterior is a caution with the parameters' names") {
  const sim::Protocol protocol = test::sines_protocol();
  const sim::ParameterTable& table = protocol.parameters();
  const posterior::Density density(protocol, {});
  posterior::Posterior found = posterior::sample(
      density, density.observe(test::recorded(protocol, test::some_parameters(), 0.02, 0)), test::quick());
  // One component, with independent coordinates around the middle of the ranges.
  std::vector<double> outputs{0.0};
  outputs.resize(1 + table.size(), 0.0);
  outputs.resize(1 + 2 * table.size(), 1.5);
  outputs.resize(mixture_outputs(1, table.size()), 0.0);
  const ParameterDistribution network(Mixture(1, table.size(), outputs), table);
  const auto warnings_at = [&](double deviations) {
    posterior::State state = found.states().front();
    for (std::size_t p = 0; p < table.size(); ++p) state.parameters[p] = network.mean(static_cast<int>(p));
    state.parameters[sim::Delay] += deviations * network.stddev(sim::Delay);
    test::set_posterior(found, std::vector(found.states().size(), state), found.rhat(), found.effective_draws());
    return contradiction_warnings(table, found, network);
  };
  CHECK(warnings_at(3.4).empty());
  CHECK(warnings_at(-3.4).empty());
  for (const double deviations : {-3.6, 3.6}) {
    const Warnings warnings = warnings_at(deviations);
    REQUIRE(warnings.size() == 1);
    CHECK(warnings[0].code == "network_disagrees");
    CHECK(warnings[0].severity == Severity::caution);
    CHECK(test::contains(warnings[0].text, "delay"));
    CHECK_FALSE(test::contains(warnings[0].text, "Kp"));
  }
}

}  // namespace decid
