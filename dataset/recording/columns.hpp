// Columns of a table by their names: which is the time, in which unit a column is, which one the user means.
// Private to recording.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "dataset/recording/recording.hpp"
#include "dataset/recording/table.hpp"

namespace decid::dataset {

/// Rates that differ by less are equal: over a trial of 121 s the difference is a sample.
inline constexpr double rate_tolerance = 1e-4;

/// Six significant digits: "50", "127.4".
std::string six_digits(double value);

/// A column's name in its parts, lower case: "COM_x (deg)" -> com, x, deg.
std::vector<std::string> words(std::string_view name);
bool one_of(std::string_view word, std::initializer_list<std::string_view> list);
/// The unit that a name ends in, if any.
std::optional<Unit> unit_in(std::string_view name);
/// "com_x" of "COM_x (deg)".
std::string name_without_unit(std::string_view name);
/// The names of a table's columns except one (-1: of all), to be shown.
std::string list_of(const Table& table, int without);

/// The column that the user named, by its name, its name in other case, or its number. Throws Error if there is none or
/// more than one. `where` names the file, `setting` how columns are named: "--column".
int named_column(const Table& table, const std::string& column, const std::string& where, const std::string& setting);

/// The column of time, or -1.
int find_time(const Table& table);

/// Seconds in one unit of a column of time, by its name.
double time_unit_s(std::string_view name);

}  // namespace decid::dataset
