// The fits of a call's recordings: alone or together, shared among ranks, and those that a journal has left out.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "identify/study/study_results.hpp"
#include "tools/decid/commands/fit_journal.hpp"

namespace decid::tools {

struct FitCall {
  const std::vector<RecordingSource>& sources;
  std::string files;              ///< the list of recordings, which all ranks must have
  std::string joint, conditions;  ///< see joint_groups(); joint empty: each recording is fitted alone
  bool quiet = false;
};

/// The results of a call's recordings, in order; empty for a recording whose fit has not begun.
using FitResults = std::vector<std::optional<RecordingResult>>;

/// Fits the recordings that the journal does not have, group by group; the ranks share the groups. journal: null for
/// none. Throws Error for columns that joint_groups() refuses, and if ranks have other recordings.
FitResults fit_all(const FitCall& call, PlanFitter& fitter, const RecordingPlan& plan, FitJournal* journal);

}  // namespace decid::tools
