// Headers that do not fit their table: more or fewer names than columns, or other separators. Not installed.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace decid::recording {

struct Misfit {
  std::string problem = {}, remedy = {};  ///< as in an Error; empty if the header fits
};

/// Describes the problem if `line`, directly above a table and unlike its rows, looks like its header. A header begins
/// with a time's name between separators, or half of its names are known; one name must be a time's or have a unit or
/// another quantity. A single name must have a unit or another quantity. Numbers, keys ("Patient: Anna", "fs=100") and
/// prose are not headers. `separator` and `columns` are the table's; `in_quotes`: an earlier line opens a quote and
/// does not close it.
Misfit misfit_header(std::string_view line, std::size_t line_number, char separator, std::size_t columns,
                     bool in_quotes);

/// Returns true if the line has an unbalanced quote.
bool has_odd_quotes(std::string_view line);

/// Returns the plural noun of a cell separator, for messages: "semicolons".
const char* separators_called(char separator);

}  // namespace decid::recording
