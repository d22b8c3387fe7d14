// Text for people and files: formatted, cleaned, tables of numbers.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace decid {

/// printf's formatting into a string.
[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...);

/// "1 trial", "2 trials".
std::string counted(long long count, const std::string& noun);

/// Seconds for people, rounded up: "42 s", "3 min 20 s", "1 h 12 min".
std::string duration_text(double seconds);

/// The system's words for a value of errno: "No space left on device".
std::string errno_text(int error);

/// Control characters become question marks: one line, whatever a file's name holds.
std::string one_line(std::string text);
/// Returns the text with U+FFFD for each run of bytes that begins like a character of UTF-8 and is none, as JSON has
/// it.
std::string valid_utf8(std::string_view text);

/// Text as a cell of a CSV file, quoted where its form needs it (RFC 4180); behind an apostrophe where a spreadsheet
/// would take it for a formula.
std::string csv_cell(const std::string& text);

/// A CSV file: a header and rows of numbers, `digits` significant ones.
std::string csv(const std::vector<std::string>& header, const std::vector<std::vector<double>>& columns, int digits);

}  // namespace decid
