// Several recordings in one file: below each other, distinguished by a column, or as elements of MATLAB's arrays.
// Not installed.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "recording/table/table.hpp"

namespace decid::recording {

/// Returns the names of a table's recordings, in the order in which they begin. `by`: an array of a MAT-file, whose
/// elements are 1, 2, ...; else a column, or several joined by commas, whose values are the names ("s01,2"). Rows with
/// an empty value belong to no recording. Throws Error for a missing column, and for one that does not distinguish
/// recordings; `where` names the file.
std::vector<std::string> trials_in(const Table& table, const std::string& by, const std::string& where);

/// Returns the columns that `by` names; none if it is an array. Throws Error for a missing column, and for a file whose
/// format holds only one recording.
std::vector<int> trial_columns(const Table& table, const std::string& by, const std::string& where);

/// Drops all other recordings. Throws Error as trials_in, and for an unknown name.
void keep_trial(Table& table, const std::string& by, const std::string& trial, const std::string& where);

/// Throws Error if a column as long as the sway changes and its name says that the file holds several recordings. A
/// column trial, block, subject, participant, session or repetition says so always. One of another person's or trial's
/// name (VP, Proband, rep) says so only if the times start again or cannot be one recording's; so does run, condition,
/// id, eyes or set, if it does not return to an earlier value. The error names the column that distinguishes them.
void refuse_several_trials(const Table& table, int sway, int time, const std::string& where);

/// Returns the remedy for a file whose times start again at the rows `starts`: the --trial that distinguishes its
/// recordings, in addition to the given columns `by`, or else one file per recording.
std::string remedy_for_several(const Table& table, int sway, int time, const std::vector<std::size_t>& starts,
                               const std::string& by);

/// Describes the first column, except sway and time, whose values are a stretch of rows each: the file may hold several
/// recordings. It has 2 to 10 values; or more, with a name as above, if each lasts 2 s in the mean. Empty without one.
/// The second result is the time from the first row to the second of two values, if the name is not a recording's: the
/// column may be a trigger. `rate_hz`: of the rows.
std::pair<std::string, std::optional<double>> describe_change(const Table& table, int sway, int time, double rate_hz);

/// Returns the sway column, or one called trial or similar, that has the times of one recording if the time column has
/// none: their names may be swapped. Empty otherwise.
std::string exchanged_with_time(const Table& table, int sway, int time);

}  // namespace decid::recording
