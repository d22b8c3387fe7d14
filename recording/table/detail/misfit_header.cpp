// Headers that do not fit their table: see misfit_header.hpp.
#include "recording/table/detail/misfit_header.hpp"

#include <algorithm>
#include <vector>

#include "base/text.hpp"
#include "recording/table/cells.hpp"
#include "recording/table/columns.hpp"
#include "recording/table/detail/commented_header.hpp"

namespace decid::recording {

namespace {

using NameViews = std::vector<std::string_view>;

/// Returns the separator between the names of a line; the table's separator comes first.
char separator_of_names(std::string_view line, char of_table) {
  for (const char each : {of_table, ';', '\t', '|', ','})
    if (line.find(each) != line.npos) return each;
  return ' ';
}

/// Returns true for "cm", "(cm)" and "[deg]"; single letters may have other meanings.
bool is_unit_alone(std::string_view name) {
  const std::string unit = unit_of_cell(name).value_or("");
  return unit.size() > 1 || (!unit.empty() && unit != name);
}

/// Returns true for the name of a time, and for a name with a unit or a quantity, which decides how numbers are read.
bool is_distinctive(std::string_view name) {
  return is_time_name(name) || unit_in(name) || find_metres_per_unit(name) || other_quantity(name) != nullptr ||
         is_unit_alone(name);
}

bool is_prose(std::string_view name) {
  constexpr std::size_t max_words = 4;
  const std::vector<std::string> parts = words(name);
  return parts.size() > max_words || std::ranges::any_of(parts, [](const std::string& word) {
           return one_of(word, {"of", "the", "for", "and", "with", "by", "from", "der", "die", "das", "und", "von"});
         });
}

bool is_key(std::string_view name) {
  return name.find_first_of(":=") != name.npos;
}

bool is_header(const NameViews& names, char separator) {
  if (is_key(names.front()) || std::ranges::any_of(names, is_value)) return false;
  if (names.size() == 1)
    return is_distinctive(names[0]) && !is_time_name(names[0]) && names[0].find(' ') == std::string_view::npos;
  if (separator == ' ' && (std::ranges::any_of(names, is_key) || std::ranges::any_of(names, is_prose))) return false;
  if (std::ranges::none_of(names, [](std::string_view name) { return is_distinctive(name) && !is_prose(name); }))
    return false;
  if (separator != ' ' && is_time_name(names.front()) && !is_prose(names.front())) return true;
  const auto known = std::ranges::count_if(names, [](std::string_view name) {
    return is_known_name(name) || is_unit_alone(name) || one_of(name, {"x", "y", "z", "X", "Y", "Z"});
  });
  return 2 * known >= std::ssize(names);
}

}  // namespace

bool has_odd_quotes(std::string_view line) {
  return std::ranges::count(line, '"') % 2 != 0;
}

const char* separators_called(char separator) {
  return separator == ';'    ? "semicolons"
         : separator == '\t' ? "tabs"
         : separator == ' '  ? "blanks"
         : separator == '|'  ? "bars"
                             : "commas";
}

Misfit misfit_header(std::string_view line, std::size_t line_number, char separator, std::size_t columns,
                     bool in_quotes) {
  constexpr std::size_t longest = 60;
  std::string problem = "line " + std::to_string(line_number) + ", '" + std::string(line.substr(0, longest)) +
                        (line.size() > longest ? "..." : "") + "', ";
  if (in_quotes && has_odd_quotes(line) && trim(line).ends_with('"'))
    return {problem + "ends a header with names of several lines", "write the names in one line"};
  const char of_names = separator_of_names(line, separator);
  NameViews names;
  split(line, of_names, names);
  while (names.size() > 1 && names.back().empty()) names.pop_back();
  if (!is_header(names, of_names)) return {};
  problem += "looks like the table's header, but has " + counted(std::ssize(names), "name");
  if (names.size() > 1) problem += std::string(" between ") + separators_called(of_names);
  problem += "; the lines below it have " + counted(static_cast<std::ptrdiff_t>(columns), "column");
  if (columns > 1) problem += std::string(" between ") + separators_called(separator);
  const bool decimal_commas = separator == ',' && columns == 2 * names.size();
  return {problem, decimal_commas ? "save the file with semicolons between columns if its numbers have decimal commas, "
                                    "else correct this line"
                                  : "correct this line: a name for each column, between the same separators"};
}

}  // namespace decid::recording
