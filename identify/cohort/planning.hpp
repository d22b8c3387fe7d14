// The uncertainty of recordings of a planned study, for cohort/power.hpp.
#pragma once

#include <cstdint>
#include <string>

#include "identify/network/model.hpp"
#include "posterior/density/priors.hpp"

namespace decid::cohort {

/// The standard deviations of values of single recordings, SI units: between participants, and between recordings of a
/// person.
struct ValueSpread {
  sim::Parameters participant_sd, measurement_sd;
};

/// Two groups of participants, N(at, participant_sd^2) and N(at + difference, participant_sd^2), within the ranges.
struct PlannedGroups {
  sim::Parameters at, difference, participant_sd;
};

/// Throws Error for a mean of a group outside of a parameter's range: `at`, or `at` + `difference` of the second group.
/// For `at` the remedy has hint_of_unit(), unless mgh_nm_rad is 0.
void check_mean(const sim::ParameterInfo& info, double at, double difference, double mgh_nm_rad);
/// Throws Error as check_mean() for the first parameter with a mean outside of its range.
void check_means(const sim::ParameterTable& table, const PlannedGroups& groups, double mgh_nm_rad);

/// Returns a hint for a value that may be over m g h of this body (mgh_nm_rad, N m/rad): " (Kp is in N m/rad: 0.9 m g h
/// is 755)". Empty for parameters that have no such values, and for 0 and values beyond 2.
std::string hint_of_unit(const sim::ParameterInfo& info, double value, double mgh_nm_rad);

/// Returns the spread of the values that the model's network gives, over the fraction of a difference that it shows.
/// A network shrinks values towards the middle of their range, and its error depends on the person's other parameters.
/// So neither the network's own standard deviation nor its error over all of the ranges predicts a study: both groups
/// are simulated, twice per person, with the recording artefacts of the protocol and the same noise in both groups.
/// Parameters without a difference get 0. Throws Error for fewer than two participants, a mean outside of the ranges,
/// controllers that do not stand, and a parameter of whose difference the network shows less than a tenth.
ValueSpread spread_of_network(const Model& model, const sim::Protocol& protocol, const PlannedGroups& groups,
                              int participants, std::uint64_t seed);

/// Returns the spread of the values of posterior::sample(), from their expected posterior variance
/// (posterior/planning/expected_posterior.hpp) at the first group's participants, its prior divided out. The
/// measurement_sd of a parameter that the priors fix is NaN, because a fit does not measure it. Throws Error as
/// posterior::expected_posterior().
ValueSpread spread_of_fits(const sim::Protocol& protocol, const posterior::Priors& priors, const PlannedGroups& groups,
                           double sensor_noise_deg, int participants, std::uint64_t seed);

}  // namespace decid::cohort
