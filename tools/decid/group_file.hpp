// Reads which group and which person each recording belongs to, from a table made with a spreadsheet.
#pragma once

#include <string>
#include <vector>

#include "identify/groups.hpp"
#include "tools/decid/options.hpp"
#include "tools/decid/recording_flags.hpp"

namespace decid::tools {

/// Reads the group and the person of each recording from a sheet (identify/study/sheet.hpp) with the column "group",
/// and "file" or a column of people; the others do not count. A line is of the recordings of which it is in a study's
/// sheet (Choice::for_groups). An empty group, or n/a, keeps a recording out of the comparison. Letter case and the
/// form of accents do not count. Throws Error, with the line, for a table without these columns, for a line with too
/// many cells or without a cell of the group, for a line with a group and no person, for two different lines of one
/// recording, for a recording without a line, and as refuse_groups() does.
GroupTable read_group_table(const std::string& table, const std::vector<RecordingSource>& recordings,
                            std::size_t min_groups = 2);

/// The values of the options that compare participants.
struct GroupFlags {
  std::string table, within, covariates;  ///< within, covariates: columns of the sheet, separated by commas

  /// Returns true if the call compares participants.
  bool given() const { return !table.empty() || !within.empty() || !covariates.empty(); }
};

/// Reads the table for the recordings that were found; without a table all participants are of one group. If the table
/// is the plan's sheet, a recording has the group and the person of its line there. Sessions, conditions and covariates
/// come from the sheet; a recording without one of the compared sessions or conditions is left out. Prints on standard
/// error which lines are of no recording, and how many recordings are left out, unless `quiet`. Throws Error also for a
/// recording that is given twice, under whatever name: it would count as two people; for --within and --covariates
/// without a sheet; for fewer than two cells; and for a covariate without two values.
GroupTable read_groups(const GroupFlags& flags, const RecordingFlags& recordings, const RecordingPlan& plan,
                       bool quiet);

/// Adds --group, --within and --covariates, of the commands that compare groups.
void add_group_options(const Command& command, GroupFlags& flags);

}  // namespace decid::tools
