// The hierarchical model of a report's groups, as JSON: identify/cohort/cohort.hpp has the model.
#pragma once

#include "base/files/json.hpp"
#include "identify/result.hpp"

namespace decid::tools {

/// Returns
///   {"draws", "max_rhat",
///    "groups": [{"name", "group", "session", "condition", "participants", "recordings", "parameters": [{"name",
///    "mean",
///                "mean_sd", "mean_interval95", "between_sd", "between_sd_interval95"}]}],
///    "comparisons": [{"groups": [a, b], "participants_in_both", "parameters": [{"name", "difference", "sd",
///    "interval95",
///                     "simultaneous95", "standardised", "standardised_interval95", "probability_of_direction"}]}],
///    "interactions": [{"first": [a, b], "second": [c, d], "parameters": as of comparisons}],
///    "covariates": [{"name", "mean", "unknown", "parameters": [{"name", "slope", "sd", "interval95",
///                    "probability_of_direction"}]}],
///    "variance": [{"name", "participant_sd", "visit_sd", "trial_sd", "measurement_sd"}],
///    "changes": [{"participant_id", "groups": [a, b], "parameters": [{"name", "difference", "interval95",
///    "changed"}]}]}
/// and null without a hierarchical model.
Json cohort_json(const Report& report);

/// Returns the reliability of each pair of groups with participants in both:
///   [{"groups": [a, b], "participants", "parameters": [{"name", "icc_single", "icc_single_interval95", "icc_average",
///     "icc_average_interval95", "standard_error", "minimal_detectable_change", "participant_sd", "visit_sd",
///     "measurement_sd", "within_participant_sd"}]}]
Json reliability_json(const Report& report);

}  // namespace decid::tools
