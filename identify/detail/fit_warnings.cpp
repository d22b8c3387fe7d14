// Warnings of a posterior: see fit_warnings.hpp.
#include "identify/detail/fit_warnings.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>

#include "base/setting.hpp"
#include "base/text.hpp"
#include "posterior/sampling/diagnostics.hpp"

namespace decid {
namespace {

using posterior::Density;
using posterior::Posterior;

// at_edge: the prior's probability that counts as an end, and the number of quantities there that is refused; the
// probability that counts as the last of an end, and the number of quantities there that is cautioned. Three of sixteen
// clean trials have three quantities in the outer twentieth (docs/guide/warnings.md).
constexpr double outer = 0.05, outermost = 0.011;  // coordinates end at the outer hundredth
constexpr std::size_t edges_of_invalid = 4, outermost_of_caution = 2;
/// Standard error of the 5% quantile of N independent draws, in standard deviations, times the square root of N.
constexpr double of_interval_end = 2.1;
constexpr double slow_rhat = 1.2;  // of noise, start and gain
constexpr double divergent_fraction = 0.05;
/// White noise of this size per sample, in a block of 0.1 s, is about the model's own error.
constexpr double min_believed_noise_deg = 2e-3;
constexpr double unexplained_white = 3.0;  // over the white noise that the highest frequencies have
constexpr double unexplained_slow = 0.5;   // over the sway's standard deviation
constexpr double contradiction_sd = 3.5;
/// In standard deviations of the gain's prior. Posterior means of gains that the prior describes are nearer in 98.8% of
/// trials or more, because they vary less than the gains.
constexpr double unlikely_scale_sd = 2.5;
/// Response gains (recording/trial.hpp) that a sway without a response exceeds with a probability of 5% and 2%
/// (63 and 21 of 1,200 recordings of other stimuli).
/// The second one holds with quantities at the ends of their priors; with one of them, weak but sound responses have it
/// too.
constexpr double chance_gain = 24.0, chance_gain_at_edges = 28.0;
constexpr std::size_t edges_without_response = 2;

std::string quantity_name(const Density& density, int quantity) {
  const sim::ParameterTable& table = density.ranges();
  if (static_cast<std::size_t>(quantity) < table.size()) return table[static_cast<std::size_t>(quantity)].name;
  return quantity == Density::sensor_noise ? "the measurement noise"
         : quantity == Density::start      ? "the start"
                                           : "the gain";
}

std::string quantity_names(const Density& density, const std::vector<int>& quantities) {
  return joined(quantities, ", ", [&](int quantity) { return quantity_name(density, quantity); });
}

/// Returns the names of the settings that widen the priors of quantities.
std::string settings_of(const std::vector<int>& quantities) {
  std::vector<std::string> names;
  for (const int quantity : quantities) {
    const std::string name = setting(quantity == Density::sensor_noise ? "prior_noise"
                                     : quantity == Density::start      ? "prior_start"
                                     : quantity == Density::gain       ? "prior_gain"
                                                                       : "ranges");
    if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  }
  return joined(names, ", ");
}

/// Returns the mean of the gain's logarithm in standard deviations of its prior; 0 for a known gain.
double scale_off_prior(const Density& density, const Posterior& found) {
  if (!density.infers(Density::gain)) return 0.0;
  double sum = 0.0;
  for (const posterior::State& state : found.states()) sum += density.prior_coordinate(Density::gain, state);
  return sum / static_cast<double>(found.states().size());
}

Warnings scale_warnings(const Density& density, const Posterior& found) {
  const double off = scale_off_prior(density, found);
  if (std::abs(off) <= unlikely_scale_sd) return {};
  return {{Severity::caution, "scale_unlikely",
           format("the sway is %.3g +- %.2g times as large as the priors expect (%.1f of their standard deviations): "
                  "check the unit, the height of the marker and the amplitude of the tilt",
                  found.mean(Density::gain), found.stddev(Density::gain), std::abs(off))}};
}

Warnings edge_warnings(const Density& density, const Posterior& found, NetworkUse network) {
  const std::vector<int> edges = at_edge(density, found, outer);
  const bool from_network = network == NetworkUse::answers;
  const std::vector<int> last = from_network ? std::vector<int>() : at_edge(density, found, outermost);
  const bool is_refused = edges.size() >= edges_of_invalid, leans = last.size() >= outermost_of_caution;
  // A start beyond the prior biases the delay.
  const bool starts_elsewhere = std::ranges::find(last, int{Density::start}) != last.end();
  const Severity severity = is_refused                  ? Severity::invalid
                            : leans || starts_elsewhere ? Severity::caution
                                                        : Severity::info;
  std::vector<int> named = edges;
  // A wider prior would hide the cause that `scale_unlikely` names.
  if (severity == Severity::info && std::abs(scale_off_prior(density, found)) > unlikely_scale_sd)
    std::erase(named, int{Density::gain});
  if (named.empty()) return {};
  return {{severity, "at_edge",
           "at the end of the prior: " + quantity_names(density, named) +
               (is_refused || leans ? "; the recording may not be of this model"
                                    : "; the true value may lie beyond it (" + settings_of(named) + ")")}};
}

/// Returns the fewest effective draws of the 5% and 95% quantiles of the inferred parameters.
double min_tail_draws(const Density& density, const Posterior& found) {
  double fewest = std::numeric_limits<double>::infinity();
  for (int p = 0; p < density.parameters(); ++p)
    if (density.infers(p)) fewest = std::min(fewest, found.tail_effective_draws(p));
  return fewest;
}

Warnings prior_warnings(const Density& density, const Posterior& found) {
  std::vector<double> means;
  for (int p = 0; p < density.parameters(); ++p) means.push_back(found.mean(p));
  const std::string names = posterior::contradicted_priors(density.priors().parameters, density.ranges(), means);
  if (names.empty()) return {};
  return {{Severity::caution, "prior_contradicted",
           "the recording and the prior contradict each other in " + names +
               ": the values lie more than 5 of the prior's standard deviations from its mean; check the prior's unit "
               "and the recording"}};
}

Warnings chain_warnings(const Density& density, const Posterior& found, NetworkUse network) {
  Warnings warnings;
  const bool from_network = network == NetworkUse::answers;
  const std::vector<double>& rhat = found.rhat();
  const auto parameters = rhat.begin() + density.parameters();
  const auto worst = std::max_element(rhat.begin(), parameters), other = std::max_element(parameters, rhat.end());
  const auto name_at = [&](auto place) {
    return quantity_name(density, density.quantity(static_cast<std::size_t>(place - rhat.begin())));
  };
  if (found.chains_disagree() || (network == NetworkUse::none && !(found.max_rhat() <= posterior::max_lone_rhat))) {
    const std::string apart = format(
        "the chains do not agree (R-hat %.2f for %s): the recording may fit more than one "
        "controller; these are ",
        *worst, name_at(worst).c_str());
    // The network's answer is as good as the answer of `identify`; its own warnings are listed too.
    if (from_network)
      add_info(warnings, "chains_disagree", apart + "the network's values, as decid identify has them");
    else
      add_caution(warnings, "chains_disagree", apart + "means over all of them");
  } else if (!found.agreed()) {
    const double fewest = min_tail_draws(density, found);
    std::string text = format(
        "the chains agree roughly (R-hat %.2f for %s, %.0f effective draws in the tails at least): ends of intervals "
        "are "
        "known to %.1f standard deviations or so",
        *worst, name_at(worst).c_str(), fewest, of_interval_end / std::sqrt(fewest));
    if (*other > slow_rhat) text += format("; %s is known less well (R-hat %.2f)", name_at(other).c_str(), *other);
    add_info(warnings, "few_draws", text);
  }
  if (!from_network && found.divergences() > divergent_fraction * found.draws())
    add_caution(warnings, "divergences",
                format("%d of %d transitions diverged: chains may have missed a part of the posterior",
                       found.divergences(), found.draws()));
  return warnings;
}

Warnings noise_warnings(const posterior::Observation& observation, const Posterior& found) {
  Warnings warnings;
  const double white_deg = found.mean(Density::sensor_noise), slow_deg = found.mean(Density::slow_noise);
  if (white_deg < min_believed_noise_deg)
    add_caution(warnings, "little_noise",
                format("the measurement noise, %.2g degrees, is at most about the error of the model's own arithmetic: "
                       "the intervals may be too narrow",
                       white_deg));
  double squares = 0.0;
  for (const double sway : observation.sway) squares = std::fma(sway, sway, squares);
  const double sway_deg = std::sqrt(squares / static_cast<double>(observation.sway.size())) / sim::rad_per_deg;
  if (white_deg > unexplained_white * std::max(observation.noise_deg, 1e-3) || slow_deg > unexplained_slow * sway_deg)
    add_caution(
        warnings, "unexplained_sway",
        format(
            "the model leaves %.3g degrees of white and %.3g of slow noise unexplained; the sway is %.3g, its "
            "noise above 2 Hz %.3g: the intervals assume that the rest is noise; check that the platform played this "
            "protocol, and its start",
            white_deg, slow_deg, sway_deg, observation.noise_deg));
  return warnings;
}

}  // namespace

std::vector<int> at_edge(const Density& density, const Posterior& found, double probability) {
  std::vector<int> edges;
  const double low = inverse_normal(probability);
  for (std::size_t place = 0; place < static_cast<std::size_t>(density.globals()); ++place) {
    const int quantity = density.quantity(place);
    if (density.is_held(place) || !density.infers(quantity)) continue;
    std::size_t below = 0, above = 0;
    for (const posterior::State& state : found.states()) {
      const double x = density.prior_coordinate(quantity, state);
      below += x < low ? 1 : 0;
      above += x > -low ? 1 : 0;
    }
    if (2 * std::max(below, above) >= found.states().size()) edges.push_back(quantity);
  }
  return edges;
}

Warnings posterior_warnings(const Density& density, const posterior::Observation& observation, const Posterior& found,
                            NetworkUse network) {
  Warnings warnings = scale_warnings(density, found);
  append(warnings, edge_warnings(density, found, network));
  append(warnings, prior_warnings(density, found));
  append(warnings, chain_warnings(density, found, network));
  append(warnings, noise_warnings(observation, found));
  return warnings;
}

bool may_not_follow_tilt(const recording::Trial& trial) {
  return trial.response_gain && !trial.other_start_s && *trial.response_gain <= chance_gain_at_edges;
}

Warnings tilt_warnings(const Density& density, const Posterior& found, const recording::Trial& trial) {
  if (!may_not_follow_tilt(trial)) return {};
  std::vector<int> edges = at_edge(density, found, outer);
  std::erase(edges, int{Density::start});  // of a recording that starts elsewhere
  const bool are_several = edges.size() >= edges_without_response;
  if (*trial.response_gain > (are_several ? chance_gain_at_edges : chance_gain)) return {};
  const Severity severity = are_several ? Severity::invalid : edges.empty() ? Severity::info : Severity::caution;
  const std::string at_ends =
      edges.empty() ? "; the values rest on its noise: "
                    : ", and the fit is at the end of the prior of " + quantity_names(density, edges) + ": ";
  const bool is_measured = trial.tilt || trial.tilt_at_given_start;
  const std::string remedy =
      is_measured ? "the measured tilt is the protocol's, so the column may not be the sway of this trial; check " +
                        setting("column")
                  : "the platform may have played another stimulus, or the column is not the sway; check " +
                        setting("protocol") + ", " + setting("begin") + " and " + setting("column");
  return {{severity, "tilt_not_followed", "the sway does not measurably follow the tilt" + at_ends + remedy}};
}

Warnings falling_warnings(const PredictiveCheck& check) {
  Warnings warnings;
  const int falling = PredictiveCheck::trials - check.standing;
  if (20 * falling > PredictiveCheck::trials)
    add_caution(warnings, "draws_fall",
                format("in %d of %d trials simulated from the draws the body falls: the draws include controllers with "
                       "which this body cannot stand, so means and intervals are off; give narrower ranges with %s, "
                       "first of the delay",
                       falling, PredictiveCheck::trials, setting("ranges").c_str()));
  return warnings;
}

Warnings refuse_unexplained(Warnings warnings) {
  const auto has = [&](const char* code) { return has_code(warnings, code); };
  if (!has("out_of_distribution") || !(has("unexplained_sway") || has("unlike_simulated"))) return warnings;
  for (Warning& warning : warnings)
    if (warning.code == "tilt_not_followed") warning.severity = Severity::invalid;
  return warnings;
}

Warnings contradiction_warnings(const sim::ParameterTable& table, const Posterior& found,
                                const ParameterDistribution& network) {
  Warnings warnings;
  std::string names;
  for (std::size_t p = 0; p < table.size(); ++p) {
    const int quantity = static_cast<int>(p);
    const double own = found.stddev(quantity), other = network.stddev(quantity);
    const double apart = std::abs(found.mean(quantity) - network.mean(quantity));
    if (apart > contradiction_sd * std::sqrt(own * own + other * other))
      names += (names.empty() ? "" : ", ") + table[p].name;
  }
  if (!names.empty())
    add_caution(warnings, "network_disagrees",
                "the posterior and the network contradict each other beyond their intervals in " + names +
                    ": check the recording for a fault");
  return warnings;
}

}  // namespace decid
