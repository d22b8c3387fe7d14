// Warnings of a posterior: signs that its chains, its model or its priors shaped the answer more than the recording
// did.
#pragma once

#include <optional>

#include "base/warning.hpp"
#include "identify/estimate.hpp"
#include "identify/predictive_check.hpp"
#include "posterior/posterior.hpp"
#include "recording/trial.hpp"

namespace decid {

/// The part that a network has in an answer. `none`: no network knows this controller, protocol and priors, so
/// nothing shows what the chains missed. `beside`: a network's answer is compared with the chains', which is the
/// result. `answers`: the result is the network's because the chains are apart.
enum class NetworkUse { none, beside, answers };

/// Returns the quantities that have half of their draws at either end of the prior, where the prior has this
/// probability. The slow noise, which chains hold while they draw, is not judged.
std::vector<int> at_edge(const posterior::Density& density, const posterior::Posterior& found, double probability);

/// Returns what the posterior itself shows: `scale_unlikely` if the mean of the gain's logarithm is more than 2.5 of
/// the prior's standard deviations from 0, `at_edge`, `prior_contradicted`, `chains_disagree`, `few_draws`,
/// `divergences`, `little_noise`, `unexplained_sway`.
Warnings posterior_warnings(const posterior::Density& density, const posterior::Observation& observation,
                            const posterior::Posterior& found, NetworkUse network);

/// Returns `draws_fall` if the body falls in more than a twentieth of the trials that are simulated from the draws:
/// these draws are controllers with which no recorded body stands.
Warnings falling_warnings(const PredictiveCheck& check);

/// Returns true if tilt_warnings() of some posterior are not empty.
bool may_not_follow_tilt(const recording::Trial& trial);

/// Returns `tilt_not_followed` if the sway does not measurably respond to the tilt, from the protocol's start or up to
/// 0.6 s later; nothing if the trial has `other_start`. With another stimulus than the protocol's, the fit drives
/// quantities to the ends of their priors: info for none of them there, caution for one, invalid for two or more
/// without the start. docs/research/posterior.md says how often.
Warnings tilt_warnings(const posterior::Density& density, const posterior::Posterior& found,
                       const recording::Trial& trial);

/// Returns the warnings of a fit with `tilt_not_followed` as invalid if the network warns (`out_of_distribution`) and
/// the draws do not explain the recording (`unexplained_sway` or `unlike_simulated`). Each of the three also occurs for
/// sound recordings.
Warnings refuse_unexplained(Warnings warnings);

/// Returns `network_disagrees` if the posterior's and the network's means of a parameter are further apart than 3.5 of
/// their joint standard deviations.
Warnings contradiction_warnings(const sim::ParameterTable& table, const posterior::Posterior& found,
                                const ParameterDistribution& network);

}  // namespace decid
