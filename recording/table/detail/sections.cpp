// Sections of a text: see sections.hpp.
#include "recording/table/detail/sections.hpp"

#include <algorithm>
#include <optional>
#include <set>

#include "base/error.hpp"
#include "base/number.hpp"
#include "base/setting.hpp"
#include "base/text.hpp"
#include "recording/table/cells.hpp"
#include "recording/table/table.hpp"

namespace decid::recording {

namespace {

/// Lines of a header may also consist of a word and a number.
constexpr std::size_t rows_of_a_table = 3, rows_that_begin_with_words = 20;

using Cells = std::vector<std::string_view>;

bool is_word(std::string_view cell) {
  return !is_value(cell) && !is_missing(cell);
}

bool begins_with_value(const Cells& cells) {
  const auto first = std::ranges::find_if(cells, [](std::string_view cell) { return !cell.empty(); });
  return first != cells.end() && !is_word(*first);
}

std::size_t filled(const Cells& cells) {
  return cells.size() - (cells.size() > 1 && cells.back().empty() ? 1 : 0);
}

/// Returns the line without separators at its end, if nothing separates cells within.
std::string full_name(std::string_view line) {
  const std::size_t end = line.find_last_not_of(",;\t\" ");
  const std::string_view name = trim(line.substr(0, end + 1));
  return end == line.npos || name.find_first_of(",;\t=") != name.npos ? std::string() : std::string(name);
}

}  // namespace

bool may_follow(const Cells& line, const Cells& row) {
  if (begins_with_value(line)) return true;
  if (filled(line) != filled(row)) return false;
  if (is_word(line.front()) && is_word(row.front())) return std::ranges::any_of(line, is_value);
  if (!is_word(line.front()) || !is_missing(row.front())) return false;
  for (std::size_t i = 1; i < filled(row); ++i)
    if (is_value(row[i]) && !is_value(line[i])) return false;
  return true;
}

std::vector<Section> find_sections(std::string_view text) {
  std::vector<Section> sections(1);
  std::size_t rows = 0, alike = 0, last_line = 0;
  std::string_view line_before;
  Cells cells, row;
  std::set<std::string_view> header;  // lines above the first rows
  for_each_line(text, [&](std::string_view line, std::size_t number) {
    split(line, guess_separator(line_before, line), cells);
    if (std::ranges::all_of(cells, &std::string_view::empty)) return true;  // a spreadsheet's blank line
    line_before = line;
    if (last_line == 0) {
      sections.back().name = full_name(line);
      sections.back().line = number;
    }
    const bool may_begin = number != last_line + 1 || line.starts_with("Interval=") || header.contains(line);
    last_line = number;
    const bool follows = !row.empty() && may_follow(cells, row);
    alike = follows ? alike + 1 : 1;
    const bool is_row = begins_with_value(cells) || (follows && begins_with_value(row));
    if (is_row || alike >= rows_that_begin_with_words) {
      rows = is_row ? rows + 1 : alike;
    } else if (may_begin && rows >= rows_of_a_table) {
      const auto begin = static_cast<std::size_t>(line.data() - text.data());
      sections.back().end = begin;
      sections.push_back({.name = full_name(line), .line = number, .begin = begin});
      rows = 0;
    } else if (rows == 0 && sections.size() == 1) {
      header.insert(line);
    }
    row = cells;
    return true;
  });
  sections.back().end = text.size();
  if (rows < rows_of_a_table) sections.pop_back();
  return sections;
}

std::string to_list(const std::vector<Section>& sections) {
  constexpr std::size_t shown_characters = 40, max_shown = 20;
  std::string list;
  for (std::size_t i = 0; i < sections.size(); ++i) {
    if (i == max_shown) return list + ", ...";
    list += (i == 0 ? "" : ", ") + std::to_string(i + 1) + " ";
    if (!sections[i].name.empty()) list += "'" + sections[i].name.substr(0, shown_characters) + "' ";
    list += "(from line " + std::to_string(sections[i].line) + ")";
  }
  return list;
}

std::string only_section(std::string_view text, const std::string& section, const std::string& where) {
  const std::vector<Section> sections = find_sections(text);
  const std::optional<std::size_t> number = number_from<std::size_t>(section);
  const auto is_asked = [&](const Section& one) { return lower_case(one.name) == lower_case(section); };
  auto found = std::ranges::find_if(sections, is_asked);
  if (found == sections.end() && number && *number >= 1 && *number <= sections.size())
    found = sections.begin() + static_cast<std::ptrdiff_t>(*number - 1);
  if (found == sections.end())
    throw Error(Code::setting_unknown, where, "has no section " + section,
                sections.empty() ? "leave out " + setting("section") : "its sections are " + to_list(sections));
  if (std::ranges::count_if(sections, is_asked) > 1)
    throw Error(Code::recording_ambiguous, where, "has several sections '" + section + "'",
                "give the number of one: " + to_list(sections));
  return std::string(line_ends(text.substr(0, found->begin)), '\n') +
         std::string(text.substr(found->begin, found->end - found->begin));
}

}  // namespace decid::recording
