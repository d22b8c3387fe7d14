// Recordings of a report as recordings of a cohort.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "identify/cohort/cohort.hpp"
#include "identify/cohort/reliability.hpp"

namespace decid {
struct RecordingResult;
struct Report;
}  // namespace decid

namespace decid::cohort {

/// Finds recordings that count: those that were fitted together have one posterior, which counts once; a network's
/// answers are each its own.
class FirstOfJoint {
 public:
  /// Returns false if a recording of the same joint fit was given before.
  bool operator()(const RecordingResult& result);

 private:
  std::set<std::vector<std::string>> seen_{};
};

struct Analysis {
  std::optional<Result> result;
  std::vector<WithoutEvidence> without_evidence;  ///< members with a group and without evidence
};

/// Analyses the inferred parameters of the groups of a report, and of their sessions and conditions. members: one per
/// recording, without its measurement; an empty group leaves it out. covariates: names of the members'. Recordings that
/// were fitted together count once. mgh_nm_rad: of the body that the results are for; empty: the report's own. No
/// result unless two cells have two participants with evidence each, or one with covariates, and each covariate two
/// values.
Analysis analyse_groups(const Report& report, std::span<const Recording> members,
                        const std::vector<std::string>& covariates = {}, std::optional<double> mgh_nm_rad = {});

/// Returns the reliability of the values of participants in both cells, by their names (cell_name()), per inferred
/// parameter; empty where it is undefined. The visits are the cells, in their order. mgh_nm_rad: as above.
std::vector<std::optional<Reliability>> compute_reliability(const Report& report, std::span<const Recording> members,
                                                            const std::string& first, const std::string& second,
                                                            std::optional<double> mgh_nm_rad = {});

/// Returns the changes of participants in both cells, by the distributions of their own recordings only. The interval
/// holds the recordings' uncertainty; that visits and trials of a person differ by themselves is not part of it.
/// Several recordings of a cell count with their mean. Leaves out recordings without a distribution of the inferred
/// parameters. mgh_nm_rad: as above.
std::vector<OwnChange> compute_own_changes(const Report& report, std::span<const Recording> members,
                                           const std::string& first, const std::string& second, double mgh_nm_rad);

/// Sets Change::own of a hierarchical model's changes.
void add_own_changes(const std::vector<OwnChange>& own, Result& result);

}  // namespace decid::cohort
