// The recordings of a plan that are fitted together, by columns of its sheet.
#pragma once

#include <string>
#include <vector>

#include "identify/fit_recordings.hpp"
#include "identify/study/recording_plan.hpp"

namespace decid {

/// Throws Error for a name that is not in the table. where: the setting that has the name.
void require_parameter(const std::string& name, const std::string& where, const sim::ParameterTable& table);

/// Parameters that differ between conditions in recordings that are fitted together.
struct FreedParameters {
  std::vector<std::string> names;
  std::string conditions;  ///< the sheet's column
};

/// Reads "NAME,..:COLUMN", such as "theta,Nv:condition"; an empty text frees nothing. Throws Error for another form,
/// and for a name that the table does not have.
FreedParameters read_freed(const std::string& text, const sim::ParameterTable& table);

/// Returns groups of two or more recordings, by their places in the plan: those with the same text in the sheet's
/// column `joint`, such as participant_id; without a sheet, all recordings if `joint` is "all". Recordings without that
/// text, and those with an error, are in no group. conditions: the column whose texts FitGroup::conditions are; empty:
/// none. Letter case does not count in these texts. Throws Error for a column that the sheet does not have
/// (StudySheet::reader_for()), and for a column of a plan without a sheet.
std::vector<FitGroup> joint_groups(const RecordingPlan& plan, const std::string& joint, const std::string& conditions);

}  // namespace decid
