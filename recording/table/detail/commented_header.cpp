// Headers after # or %: see commented_header.hpp.
#include "recording/table/detail/commented_header.hpp"

#include <algorithm>

#include "recording/table/cells.hpp"
#include "recording/table/columns.hpp"

namespace decid::recording {

namespace {

/// Returns the comments and blank lines at the end of a text, the last one first.
std::vector<std::string_view> comments_of(std::string_view above) {
  constexpr std::size_t max_comments = 100;
  std::vector<std::string_view> comments;
  while (!above.empty() && comments.size() < max_comments) {
    above.remove_suffix(1);  // a line's end
    const std::size_t end = above.find_last_of("\r\n");
    std::string_view line = trim(above.substr(end == above.npos ? 0 : end + 1));
    above = above.substr(0, end == above.npos ? 0 : end + 1);
    if (line.empty()) continue;
    if (line.front() != '#' && line.front() != '%') break;
    while (!line.empty() && (line.front() == '#' || line.front() == '%')) line.remove_prefix(1);
    if (!trim(line).empty()) comments.push_back(line);
  }
  return comments;
}

/// Splits like the rows, else as programs separate names: savetxt writes a header of blanks above commas.
std::vector<std::string_view> split_cells(std::string_view comment, char separator, std::size_t columns) {
  std::vector<std::string_view> cells;
  for (const char each : {separator, ',', ';', '\t', ' '}) {
    split(comment, each, cells);
    while (cells.size() > columns && cells.back().empty()) cells.pop_back();
    if (cells.size() == columns) return cells;
  }
  return {};
}

}  // namespace

bool is_known_name(std::string_view cell) {
  if (is_time_name(cell) || unit_in(cell) || find_metres_per_unit(cell) || other_quantity(cell) != nullptr) return true;
  return std::ranges::any_of(words(cell), [](const std::string& word) {
    return one_of(word, {"sway", "com", "cog", "ksp", "tilt", "platform", "plattform", "angle", "winkel", "pitch",
                         "roll", "frame", "index"});
  });
}

std::vector<std::string> commented_names(std::string_view above, char separator, std::size_t columns) {
  std::vector<std::string_view> units;
  for (const std::string_view comment : comments_of(above)) {
    const std::vector<std::string_view> cells = split_cells(comment, separator, columns);
    if (cells.empty() || std::ranges::all_of(cells, [](auto cell) { return parse_number(cell).is_number; })) continue;
    if (units.empty() && columns > 1 && are_units(cells)) {
      units = cells;
      continue;
    }
    if (std::ranges::none_of(cells, is_known_name)) continue;
    // A remark above one column has several words: "sway of subject 3".
    if (columns == 1 && trim(cells[0]).find(' ') != std::string_view::npos && !unit_in(cells[0])) continue;
    std::vector<std::string> names;
    for (std::size_t i = 0; i < columns; ++i) {
      names.push_back(cells[i].empty() ? "column " + std::to_string(i + 1) : std::string(cells[i]));
      if (!units.empty()) names.back() = with_unit(names.back(), units[i]);
    }
    return names;
  }
  return {};
}

void read_comments(std::string_view above, std::vector<StatedRate>& rates, std::vector<StatedUnit>& units) {
  for (const std::string_view comment : comments_of(above)) {
    add_stated_rates(comment, rates);
    add_stated_unit(comment, units);
  }
}

}  // namespace decid::recording
