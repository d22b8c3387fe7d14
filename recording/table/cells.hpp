// Cells of a table written as text: split, read as numbers, as clock times, as units.
// Not installed.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recording/table/thousands.hpp"

namespace decid::recording {

/// Without blanks and tabs around it.
std::string_view trim(std::string_view text);

/// Calls visit(line, number) for every line that is neither blank nor a comment (# or %), until it returns false. Lines
/// end in \n, \r\n or \r and are counted from 1, all of them.
template <class Visit>
void for_each_line(std::string_view text, const Visit& visit) {
  std::size_t line_number = 0;
  std::size_t newline = text.find('\n');  // the first one from `begin` on
  for (std::size_t begin = 0; begin < text.size();) {
    if (newline < begin) newline = text.find('\n', begin);
    std::string_view line = text.substr(begin, newline - begin);
    line = line.substr(0, line.find('\r'));
    begin += line.size();
    begin += text.substr(begin, 2) == "\r\n" ? 2 : 1;
    ++line_number;
    const std::size_t first = line.find_first_not_of(" \t");
    if (first == line.npos || line[first] == '#' || line[first] == '%') continue;
    if (!visit(line, line_number)) return;
  }
}

/// The cells of a line, without blanks and quotes around them. A separator between quotes separates nothing; a run of
/// blanks separates once.
void split(std::string_view line, char separator, std::vector<std::string_view>& cells);

/// Each separator ends a cell: neither quotes nor runs of blanks are to be thought of.
bool is_plain(std::string_view text, char separator);

/// The cell that split() puts at `column`, which the line must have. plain: is_plain() of the line.
std::string_view cell_at(std::string_view line, char separator, std::size_t column, bool plain);

struct Parsed {
  bool is_number;  ///< also if it is not finite, or too large for a double
  double value;
};
/// A comma in a cell is a decimal one, as a separator would have ended the cell, but where digits are plainly in groups
/// of three (thousands.hpp). Fortran's exponents ("1.0D-03") are read too.
Parsed parse_number(std::string_view cell);
/// In a column whose commas have this meaning.
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

/// "deg" of "[deg]" and "(deg)", if it is a unit; empty otherwise. Brackets must close.
std::optional<std::string> unit_of_cell(std::string_view cell);

/// Returns true for a line of units: at least half of its cells are known units or empty, the others are short words,
/// and one known unit is not a number.
bool are_units(const std::vector<std::string_view>& cells);
/// Returns "sway (deg)" for "sway" and "[deg]", or only the name if the unit says nothing.
std::string with_unit(std::string name, std::string_view unit);

/// Which of ; tab | , blank separates the cells of a line of data, of which the line before it may be the header.
char separator_of(std::string_view line_before, std::string_view line);

}  // namespace decid::recording
