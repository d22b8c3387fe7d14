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

/// A line at which a table may begin, its first row of data.
class TableStart {
 public:
  TableStart(const std::vector<Line>& lines, std::size_t first)
      : lines_(lines),
        first_(first),
        end_(std::min(first + lines_of_a_table, lines.size())),
        separator_(guess_separator(first > 0 ? lines[first - 1].text : "", lines[first].text)),
        row_(cells(first)) {}

  bool is_table() const {
    if (!has_second_row() && first_ > 0) return false;
    if (row_.size() > max_columns + 1) return false;
    for (std::size_t line = first_; line < end_; ++line)
      if (!fits(line) || !is_data(cells(line))) return false;
    // A row below the names may count the samples; rows of samples have a time.
    return !(has_second_row() && row_.size() > 1 && row_[0].empty() && is_value(cells(first_ + 1)[0]));
  }

  /// Returns the lines of `text` above the table, and its names if they stand in several lines or in R's form.
  Preamble preamble(std::string_view text) const {
    if (names_of_r()) {
      Preamble found = make_preamble(text, lines_[first_ - 1].number);
      const auto header = cells(first_ - 1);
      found.names.emplace_back("row");
      found.names.insert(found.names.end(), header.begin(), header.end());
      return found;
    }
    HeaderRows rows;
    for (std::size_t line = 0; line < first_; ++line) rows.push_back(cells(line));
    const bool ends_in_separator =
        row_.back().empty() && (rows.empty() || rows.back().size() < row_.size() || rows.back().back().empty());
    if (auto names = names_of_rows(rows, row_.size() - (ends_in_separator ? 1 : 0)); !names.empty()) {
      Preamble found = make_preamble(text, lines_[first_].number - 1);
      found.names = std::move(names);
      add_section_rate(rows, found.rates);
      return found;
    }
    const std::size_t header = find_header();
    if (header == 0) return {};
    Preamble found = make_preamble(text, lines_[header].number - 1);
    add_section_rate(rows, found.rates);
    if (header == first_) found.misfit = misfit();
    return found;
  }

 private:
  std::vector<std::string_view> cells(std::size_t line) const { return split_cells(lines_[line].text, separator_); }
  bool fits(std::size_t line) const { return are_alike(cells(line), row_); }
  bool has_second_row() const { return end_ - first_ > 1; }
  bool has_time(std::size_t line) const {
    const auto names = cells(line);
    return !are_units(names) && std::ranges::any_of(names, is_time_name);
  }
  bool names_of_r() const {
    return first_ > 0 && has_second_row() && names_all_but_rows(cells(first_ - 1), row_, cells(first_ + 1));
  }

  /// Returns the line of the header, the first row's if there is none above it; 0 if nothing stands above the header.
  std::size_t find_header() const {
    if (first_ == 0 || (fits(0) && (first_ == 1 || has_time(0)))) return 0;
    // A damaged row below the header is not a header.
    if (fits(0) && std::ranges::any_of(cells(first_ - 1), is_value)) return 0;
    // A single name above one column is clear only if it has an angle's unit.
    if (row_.size() == 1 && !unit_in(lines_[first_ - 1].text)) return 0;
    std::size_t top = first_;  // of the rows, the first of which may have no values
    while (top > 0 && fits(top - 1) && std::ranges::all_of(cells(top - 1), is_missing)) --top;
    if (top == 0) return 0;
    // The header is the lowest line above that does not hold units; a line with a time is preferred.
    std::size_t header = top;
    if (fits(top - 1)) header = top - 1;
    if (header > 0 && header < top && are_units(cells(header)) && fits(header - 1)) --header;
    for (std::size_t line = top; line-- > 0 && fits(line);)
      if (has_time(line)) header = line;
    for (std::size_t line = 0; line < header; ++line) {
      const auto values = cells(line);
      if (values.size() > 1 && std::ranges::all_of(values, is_value)) return 0;
    }
    return header;
  }

  /// Describes the line above a table without a header.
  Misfit misfit() const {
    bool in_quotes = false;
    for (std::size_t line = 0; line + 1 < first_; ++line) in_quotes ^= has_odd_quotes(lines_[line].text);
    const Line& above = lines_[first_ - 1];
    return misfit_header(above.text, above.number, separator_, row_.size() - (row_.back().empty() ? 1 : 0), in_quotes);
  }

  const std::vector<Line>& lines_;
  std::size_t first_, end_;  ///< lines of the first row, and behind the last one that decides
  char separator_;
  std::vector<std::string_view> row_;
};

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
  for (std::size_t first = 0; first < lines.size(); ++first)
    if (const TableStart start(lines, first); start.is_table()) return start.preamble(text);
  return {};
}

}  // namespace decid::recording
