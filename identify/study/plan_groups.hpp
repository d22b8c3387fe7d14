// Groups, sessions, conditions and covariates of a study's participants, from the sheet of a plan.
//
//   GroupTable groups = groups_of_plan(plan, true);
//   refuse_groups(groups.members, "participants.tsv");
//   compare_within("session", plan, groups);
//   report.groups = report_groups(groups, report);      // identify/result.hpp
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "identify/fit_recordings.hpp"
#include "identify/groups.hpp"
#include "identify/study/recording_plan.hpp"

namespace decid {

/// Gives texts that differ in letter case or the form of accents one spelling, the first.
class Spelling {
 public:
  const std::string& operator()(const std::string& text);

 private:
  std::map<std::string, std::string> first_{};  // by text_key()
};

/// Splits "age,weight" into names of columns.
std::vector<std::string> split_columns(const std::string& text);

/// Returns the group and the person of every recording, by its line of the sheet. Letter case does not count in these
/// texts. by_group: false puts all recordings in cohort::everyone. Throws Error if by_group and the sheet has no column
/// "group", if only some lines of recordings name their participant (RecordingPlan::nameless), and for two groups that
/// are equal in NameOrder, such as 01 and 1.
GroupTable groups_of_plan(const RecordingPlan& plan, bool by_group);

/// Throws Error for fewer groups than `min_groups`, and for two groups that share some people, but fewer than half of
/// the smaller one's: more likely a name given twice than a comparison in pairs. where: the table, for messages. plan:
/// instead of too few groups, throws the error of its first recording that has one, such as a wrong cell.
void refuse_groups(const std::vector<GroupMember>& members, const std::string& where, std::size_t min_groups = 2,
                   const RecordingPlan* plan = nullptr);

/// Compares the sessions or the conditions of the sheet, too. column: "session" or "condition". Leaves out recordings
/// without one, and returns their number. Throws Error for another column, a plan without a sheet, fewer than two
/// values, and two that are equal in NameOrder, such as 5.3.2024 and 2024-03-05.
std::size_t compare_within(const std::string& column, const RecordingPlan& plan, GroupTable& groups);

/// Returns the numbers in a column of the plan's sheet, one per recording; NaN: n/a. Weights are in kg, heights in m.
/// Throws Error for a plan without a sheet, a column that the sheet does not have, a text that is not a number,
/// numbers that seem to have commas between thousands, and ages outside of 1 to 120 years.
std::vector<double> read_covariate(const RecordingPlan& plan, const std::string& column);

/// Adds a covariate: a column of numbers. Throws Error as read_covariate() does, for fewer than two values, for codes
/// of unknown values such as -99 and 999 that are far from all others, and for what the model of groups cannot tell.
void add_covariate(const std::string& column, const RecordingPlan& plan, GroupTable& groups);

/// Throws Error if recordings that are fitted together are compared with each other.
void refuse_joint_cells(const GroupTable& groups, std::span<const FitGroup> joint);

}  // namespace decid
