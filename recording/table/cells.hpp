// Cells of a text table: split, read as numbers, clock times and units.
// Not installed.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recording/table/detail/thousands.hpp"

namespace decid::recording {

/// Returns the text without surrounding blanks and tabs.
std::string_view trim(std::string_view text);

/// Returns true for a line that begins with # or %, behind blanks, unless its first cell is a missing value (#N/A).
bool is_comment(std::string_view line);

/// Calls visit(line, number) for every line, from 1, until it returns false. Lines end with LF, CR LF or CR.
template <class Visit>
void for_every_line(std::string_view text, const Visit& visit) {
  std::size_t line_number = 0;
  std::size_t newline = text.find('\n');  // the first one at or after `begin`
  for (std::size_t begin = 0; begin < text.size();) {
    if (newline < begin) newline = text.find('\n', begin);
    std::string_view line = text.substr(begin, newline - begin);
    line = line.substr(0, line.find('\r'));
    begin += line.size();
    begin += text.substr(begin, 2) == "\r\n" ? 2 : 1;
    ++line_number;
    if (!visit(line, line_number)) return;
  }
}

/// Calls visit(line, number) for every line that is neither blank nor a comment, until it returns false.
template <class Visit>
void for_each_line(std::string_view text, const Visit& visit) {
  for_every_line(text, [&](std::string_view line, std::size_t number) {
    const std::size_t first = line.find_first_not_of(" \t");
    if (first == line.npos || ((line[first] == '#' || line[first] == '%') && is_comment(line))) return true;
    return visit(line, number);
  });
}

/// Returns the number of line ends in a text.
std::size_t line_ends(std::string_view text);

/// Splits a line into cells, without surrounding blanks and quotes. Quoted separators do not count; a run of blanks
/// separates once.
void split(std::string_view line, char separator, std::vector<std::string_view>& cells);

/// Returns true if each separator ends a cell: the text has neither quotes nor runs of blanks.
bool is_plain(std::string_view text, char separator);

/// Returns the cell that split() puts at `column`, which the line must have. The line must be plain (is_plain).
std::string_view plain_cell(std::string_view line, char separator, std::size_t column);

struct Parsed {
  bool is_number;  ///< true also for infinite numbers and numbers too large for a double
  double value;
};
/// Reads a number. A comma in a cell is decimal, because a separator would have ended the cell, unless digits are
/// clearly in groups of three (thousands.hpp). Reads Fortran's exponents ("1.0D-03"), too.
Parsed parse_number(std::string_view cell);
/// Reads a number of a column whose commas have this meaning.
Parsed parse_number(std::string_view cell, Commas commas);

/// Returns true for a cell without a value: empty, nan, NA, null, None, missing, ? or -.
bool is_missing(std::string_view cell);

struct ClockTime {
  double day = 0.0;  ///< since the first of March of year 0; 0 without a date
  double s = 0.0;    ///< since midnight
  bool operator==(const ClockTime&) const = default;
};
/// Reads a clock time: "12:03:04.5", "12:03:04,5", "12:03:04:500", "1:03:04 PM", "03:04.5" (minutes and seconds),
/// "2026-03-05T12:03:04", "05.03.2026 12:03:04.250", "05-Mar-2026 12:03:04", "2026-03-05 12:03:04+01:00" or "0 days
/// 00:00:01.5"; and durations, "1.5 sec" or "0.025 min". Returns nothing for other text. Ignores the time zone.
std::optional<ClockTime> clock_time(std::string_view cell);

/// Returns true for a number or a clock time.
bool is_value(std::string_view cell);

/// Returns "deg" for "[deg]" and "(deg)", if it is a unit; empty otherwise. Brackets must close.
std::optional<std::string> unit_of_cell(std::string_view cell);

/// Returns true for a line of units: at least half of its cells are known units or empty, the others are short words,
/// and at least one known unit is not a number.
bool are_units(const std::vector<std::string_view>& cells);
/// Returns "sway (deg)" for "sway" and "[deg]", or only the name if the unit is meaningless.
std::string with_unit(std::string name, std::string_view unit);

/// Returns the separator (; tab | , blank) of a line of data, whose header may be the line before.
char guess_separator(std::string_view line_before, std::string_view line);

}  // namespace decid::recording
