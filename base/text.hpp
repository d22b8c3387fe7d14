// Text for users and files: formatted, cleaned, tables of numbers.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace decid {

/// Formats into a string as printf does, with decimal points in every locale.
[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...);

/// Returns "1 trial", "2 trials".
std::string counted(long long count, const std::string& noun);

/// Returns the texts of a range, separated: "a, b, c". text_of: the text of an element, if it is not one.
template <class Range, class TextOf = std::identity>
std::string joined(const Range& range, std::string_view separator, TextOf text_of = {}) {
  std::string text;
  for (const auto& element : range) {
    if (!text.empty()) text += separator;
    text += std::invoke(text_of, element);
  }
  return text;
}

/// Returns text with small letters instead of A to Z.
std::string lower_case(std::string text);

/// Returns how many letters differ between two texts: changed, missing or added ones.
std::size_t count_edits(const std::string& a, const std::string& b);

/// Formats seconds for users, rounded up: "42 s", "3 min 20 s", "1 h 12 min".
std::string duration_text(double seconds);

/// Returns the system's text for a value of errno: "No space left on device".
std::string errno_text(int error);

/// Replaces control characters by question marks, which keeps a file's name on one line.
std::string one_line(std::string text);
/// Returns the text with U+FFFD for each run of bytes that begins like a character of UTF-8 and is none, as JSON has
/// it.
std::string valid_utf8(std::string_view text);

/// Returns text as a cell of a CSV file, quoted where needed (RFC 4180); with an apostrophe before text that a
/// spreadsheet would read as a formula.
std::string csv_cell(const std::string& text);

/// Returns text as one word of a POSIX shell: plain if all of it is letters, digits and _./=,:+-, else in single
/// quotes.
std::string shell_quoted(const std::string& text);

/// Returns a CSV file: a header and rows of numbers with `digits` significant digits.
std::string csv(const std::vector<std::string>& header, const std::vector<std::vector<double>>& columns, int digits);

}  // namespace decid
