// Text above a table: see preamble.hpp.
#include "recording/table/detail/preamble.hpp"

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>

#include "base/text.hpp"
#include "recording/table/cells.hpp"
#include "recording/table/columns.hpp"
#include "recording/table/detail/header_rows.hpp"
#include "recording/table/table.hpp"

namespace decid::recording {

namespace {

/// The last line at which a table may begin.
constexpr std::size_t max_lines = 300;
/// The number of lines that make a table; fewer at the end of the file.
constexpr std::size_t lines_of_a_table = 3;

struct Line {
  std::string_view text;
  std::size_t number;
};

std::vector<std::string_view> split_cells(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  split(line, separator, cells);
  return cells;
}

/// Returns true for as many cells, or one more that is empty, after a separator at the line's end.
bool are_alike(const std::vector<std::string_view>& a, const std::vector<std::string_view>& b) {
  return a.size() == b.size() || (a.size() == b.size() + 1 && a.back().empty()) ||
         (b.size() == a.size() + 1 && b.back().empty());
}

/// Returns true if at least half of the cells hold values, including one of the first two; of two cells, both:
/// "Subject,12" is not data.
bool is_data(const std::vector<std::string_view>& cells) {
  const auto values = std::ranges::count_if(cells, is_value);
  if (cells.size() == 2)
    return std::ranges::all_of(cells, [](auto cell) { return cell.empty() || is_value(cell); }) && values > 0;
  return 2 * values >= std::ssize(cells) && (is_value(cells[0]) || (cells.size() > 1 && is_value(cells[1])));
}

/// Returns true for a header of R's write.table, above rows that begin with unnamed row numbers.
bool names_all_but_rows(const std::vector<std::string_view>& header, const std::vector<std::string_view>& first,
                        const std::vector<std::string_view>& second) {
  return header.size() + 1 == first.size() && !header.back().empty() && std::ranges::none_of(header, is_value) &&
         first[0] == "1" && second[0] == "2";
}

/// Returns the unit of "inDegrees=no", as OpenSim writes it.
std::optional<Unit> stated_unit(std::string_view line) {
  std::string text = lower_case(std::string(line));
  std::erase_if(text, [](char c) { return c == ' ' || c == '\t'; });
  if (text == "indegrees=yes") return Unit::degree;
  if (text == "indegrees=no") return Unit::radian;
  return {};
}

/// Reads TRC: a line of the file's kind, a line of names of figures, the figures, a line of markers, a line of
/// coordinates.
Preamble of_trc(const std::vector<Line>& lines) {
  constexpr std::size_t header_lines = 5;
  if (lines.size() < header_lines) return {};
  Preamble found;
  found.lines = lines[header_lines - 1].number;
  const auto figures = split_cells(lines[1].text, '\t'), values = split_cells(lines[2].text, '\t');
  std::string unit;
  for (std::size_t i = 0; i < std::min(figures.size(), values.size()); ++i) {
    if (figures[i] == "Units") unit = " (" + std::string(values[i]) + ")";
    if (figures[i] == "DataRate") add_stated_rates("DataRate\t" + std::string(values[i]), found.rates);
  }
  const auto markers = split_cells(lines[3].text, '\t'), coordinates = split_cells(lines[4].text, '\t');
  std::string marker;
  const std::size_t columns = std::min(std::max(markers.size(), coordinates.size()), max_columns + 1);
  for (std::size_t i = 0; i < columns; ++i) {
    if (i < markers.size() && !markers[i].empty()) marker = markers[i];
    const bool has_coordinate = i < coordinates.size() && !coordinates[i].empty();
    found.names.push_back(has_coordinate ? marker + " " + std::string(coordinates[i].substr(0, 1)) + unit : marker);
  }
  return found;
}

/// Returns the first lines of the text.
Preamble make_preamble(std::string_view text, std::size_t lines) {
  Preamble found{.lines = lines};
  for_each_line(text, [&](std::string_view line, std::size_t number) {
    if (number > lines) return false;
    add_stated_rates(line, found.rates);
    add_stated_unit(line, found.units);
    if (const auto unit = stated_unit(line)) found.unit = unit;
    return true;
  });
  return found;
}

}  // namespace

Preamble preamble_behind(std::string_view text, std::size_t lines) {
  std::size_t begin = 0;
  for_each_line(text, [&](std::string_view line, std::size_t number) {
    begin = static_cast<std::size_t>(line.data() - text.data());
    return number <= lines;
  });
  Preamble found = make_preamble(text, lines);
  Preamble rows = find_preamble(text.substr(begin));
  if (rows.names.empty()) return found;
  // Comment lines and blank lines before `begin` count too.
  found.lines = line_ends(text.substr(0, begin)) + rows.lines;
  found.names = std::move(rows.names);
  std::ranges::move(rows.rates, std::back_inserter(found.rates));
  std::ranges::move(rows.units, std::back_inserter(found.units));
  return found;
}

Preamble find_preamble(std::string_view text) {
  std::vector<Line> lines;
  for_each_line(text, [&](std::string_view line, std::size_t number) {
    lines.push_back({line, number});
    return lines.size() < max_lines;
  });
  if (lines.empty()) return {};
  if (lines.front().text.starts_with("PathFileType")) return of_trc(lines);
  for (std::size_t first = 0; first < lines.size(); ++first) {
    const char separator = guess_separator(first > 0 ? lines[first - 1].text : "", lines[first].text);
    const auto row = split_cells(lines[first].text, separator);
    const auto fits = [&](std::size_t line) { return are_alike(split_cells(lines[line].text, separator), row); };
    const auto has_time = [&](std::size_t line) {
      const auto cells = split_cells(lines[line].text, separator);
      return !are_units(cells) && std::ranges::any_of(cells, is_time_name);
    };
    const std::size_t after = std::min(first + lines_of_a_table, lines.size());
    bool is_table = (after - first > 1 || first == 0) && row.size() <= max_columns + 1;
    for (std::size_t line = first; line < after && is_table; ++line)
      is_table = fits(line) && is_data(split_cells(lines[line].text, separator));
    // A row below the names may count the samples; rows of samples have a time.
    if (is_table && after - first > 1 && row.size() > 1 && row[0].empty() &&
        is_value(split_cells(lines[first + 1].text, separator)[0]))
      continue;
    if (!is_table) continue;
    if (first > 0 && after - first > 1) {
      const auto header = split_cells(lines[first - 1].text, separator);
      const auto second = split_cells(lines[first + 1].text, separator);
      if (names_all_but_rows(header, row, second)) {
        Preamble found = make_preamble(text, lines[first - 1].number);
        found.names.emplace_back("row");
        found.names.insert(found.names.end(), header.begin(), header.end());
        return found;
      }
    }
    HeaderRows rows;
    for (std::size_t line = 0; line < first; ++line) rows.push_back(split_cells(lines[line].text, separator));
    const bool ends_in_separator =
        row.back().empty() && (rows.empty() || rows.back().size() < row.size() || rows.back().back().empty());
    std::vector<std::string> names = names_of_rows(rows, row.size() - (ends_in_separator ? 1 : 0));
    if (!names.empty()) {
      Preamble found = make_preamble(text, lines[first].number - 1);
      found.names = std::move(names);
      add_section_rate(rows, found.rates);
      return found;
    }
    if (first == 0 || (fits(0) && (first == 1 || has_time(0)))) return {};
    // A damaged row below the header is not a header.
    if (fits(0) && std::ranges::any_of(split_cells(lines[first - 1].text, separator), is_value)) return {};
    // A single name above one column is clear only if it has an angle's unit.
    if (row.size() == 1 && !unit_in(lines[first - 1].text)) return {};
    // The header is the lowest line above that does not hold units; a line with a time is preferred.
    std::size_t header = first;
    if (fits(first - 1)) header = first - 1;
    if (header > 0 && header < first && are_units(split_cells(lines[header].text, separator)) && fits(header - 1))
      --header;
    for (std::size_t line = first; line-- > 0 && fits(line);)
      if (has_time(line)) header = line;
    if (header == 0) return {};
    for (std::size_t line = 0; line < header; ++line) {
      const auto cells = split_cells(lines[line].text, separator);
      if (cells.size() > 1 && std::ranges::all_of(cells, is_value)) return {};
    }
    Preamble found = make_preamble(text, lines[header].number - 1);
    add_section_rate(rows, found.rates);
    if (header == first) {
      bool in_quotes = false;
      for (std::size_t line = 0; line + 1 < first; ++line) in_quotes ^= has_odd_quotes(lines[line].text);
      const Line& above = lines[first - 1];
      found.misfit =
          misfit_header(above.text, above.number, separator, row.size() - (row.back().empty() ? 1 : 0), in_quotes);
    }
    return found;
  }
  return {};
}

}  // namespace decid::recording
