// Several recordings in one file: below each other, told apart by a column, or the elements of MATLAB's arrays.
// Not installed.
#pragma once

#include <string>
#include <vector>

#include "recording/table/table.hpp"

namespace decid::recording {

/// The names of a table's recordings, in the order in which they begin. by: an array of a MAT-file, whose elements are
/// 1, 2, ...; else a column, or several with commas between them, whose values are the names ("s01,2"). Rows with an
/// empty value belong to none. Throws Error for a column that there is not, and one that does not tell recordings
/// apart; `where` names the file.
std::vector<std::string> trials_in(const Table& table, const std::string& by, const std::string& where);

/// The columns that `by` names; none if it is an array. Throws Error for one that there is not, and for a file of a
/// format that holds one recording.
std::vector<int> trial_columns(const Table& table, const std::string& by, const std::string& where);

/// Drops what is not of this recording. Throws Error as trials_in, and if there is none of this name.
void keep_trial(Table& table, const std::string& by, const std::string& trial, const std::string& where);

/// Throws Error if a column called trial, block, subject or the like, as long as the sway's, changes: a file of several
/// recordings. The error advises what tells them apart.
void refuse_several_trials(const Table& table, int sway, int time, const std::string& where);

/// What to do about a file whose times start again at these rows: the --trial that tells its recordings apart, beside
/// the columns of `by`, which was given; else to give each as a file of its own.
std::string remedy_for_several(const Table& table, int sway, int time, const std::vector<std::size_t>& starts,
                               const std::string& by);

/// The column of sway, or one called trial or the like, that has the times of one recording, where the column of time
/// has none: their names may be exchanged. Empty if there is none.
std::string exchanged_with_time(const Table& table, int sway, int time);

}  // namespace decid::recording
