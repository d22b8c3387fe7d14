// Several recordings in one file: below each other, told apart by a column, or the elements of MATLAB's arrays.
// Not installed.
#pragma once

#include <string>
#include <vector>

#include "dataset/recording/table.hpp"

namespace decid::dataset {

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
/// recordings.
void refuse_several_trials(const Table& table, int sway, const std::string& where);

/// What to do about a file that holds several recordings; `by`: the column that tells them apart, if there is one.
std::string remedy_for_several(const std::string& by);

}  // namespace decid::dataset
