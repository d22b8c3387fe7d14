// Recordings of a report as recordings of a cohort.
#pragma once

#include <optional>

#include "identify/cohort/cohort.hpp"
#include "identify/cohort/reliability.hpp"

namespace decid {
struct RecordingResult;
struct Report;
}  // namespace decid

namespace decid::cohort {

/// Returns the evidence of a recording of the report: the draws of its posterior, with normal priors divided out, or
/// the network's distribution. It is about the parameters that were inferred (Report::inferred_parameters()); those
/// that scale with m g h count relative to the recording's own body. Empty for the reasons of WithoutEvidence.
std::optional<Measurement> to_measurement(const RecordingResult& result, const Report& report);

struct Analysis {
  std::optional<Result> result;
  std::vector<WithoutEvidence> without_evidence;  ///< members with a group for which to_measurement() is empty
};

/// Analyses the inferred parameters of the groups of a report, and of their sessions and conditions. members: one per
/// recording, without its measurement; an empty group leaves it out. covariates: names of the members'. Recordings that
/// were fitted together count once. mgh_nm_rad: of the body that the results are for; empty: the report's own. No
/// result unless two cells have two persons with evidence each, or one with covariates, and each covariate two values.
Analysis analyse_groups(const Report& report, std::span<const Recording> members,
                        const std::vector<std::string>& covariates = {}, std::optional<double> mgh_nm_rad = {});

/// Returns the reliability of the values of persons in both cells, by their names (cell_name()), per inferred
/// parameter; empty where it is undefined. The visits are the cells, in their order. mgh_nm_rad: as above.
std::vector<std::optional<Reliability>> compute_reliability(const Report& report, std::span<const Recording> members,
                                                            const std::string& first, const std::string& second,
                                                            std::optional<double> mgh_nm_rad = {});

}  // namespace decid::cohort
