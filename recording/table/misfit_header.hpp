// A header that is not the table's: with more or fewer names than columns, or between other separators. Not installed.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace decid::recording {

struct Misfit {
  std::string problem = {}, remedy = {};  ///< as of an Error; empty if there is none
};

/// Tells what is wrong if `line`, which stands directly above a table and has not its cells, looks like its header. One
/// of a header's names is a time's, has a unit or tells another quantity; it begins with a time's between separators,
/// or half of its names are known. A name alone has a unit or tells another quantity. Numbers, keys ("Patient: Anna",
/// "fs=100") and prose make none. `separator` and `columns` are the table's; `in_quotes`: an earlier line opens a quote
/// that it does not close.
Misfit misfit_header(std::string_view line, std::size_t line_number, char separator, std::size_t columns,
                     bool in_quotes);

/// Returns true if the line opens or closes a quote that it does not close or open.
bool has_odd_quotes(std::string_view line);

/// Returns the plural noun for a separator of cells, as messages use it: "semicolons".
const char* separators_called(char separator);

}  // namespace decid::recording
