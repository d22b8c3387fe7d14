// Tables of numbers as text. One pass over the text finds its rows and checks their lengths; another pass per column
// parses its numbers. Memory holds the text, the row positions and the requested columns.
#include "recording/formats/csv.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "base/error.hpp"
#include "base/setting.hpp"
#include "base/text.hpp"
#include "recording/formats/encoding.hpp"
#include "recording/table/cells.hpp"
#include "recording/table/columns.hpp"
#include "recording/table/detail/commented_header.hpp"
#include "recording/table/detail/misfit_header.hpp"
#include "recording/table/detail/sections.hpp"

namespace decid::recording {

namespace {

std::string shown(std::string_view cell) {
  if (cell.empty()) return "the cell is empty";
  if (cell.size() > 40) return "'" + std::string(cell.substr(0, 37)) + "...' is not a finite number";
  return "'" + std::string(cell) + "' is not a finite number";
}

/// Returns true for a cell that is neither a value nor a missing one.
bool is_text(std::string_view cell) {
  return !is_missing(cell) && !is_value(cell);
}

/// Far longer than a line of 1000 columns.
constexpr std::size_t max_line_bytes = std::size_t{1} << 17;

bool has_long_line(std::string_view text) {
  for (std::size_t begin = 0; text.size() - begin > max_line_bytes;) {
    const std::size_t end = text.find_last_of("\r\n", begin + max_line_bytes);
    if (end == text.npos || end < begin) return true;
    begin = end + 1;
  }
  return false;
}

/// Returns the text. Throws Error for long lines that are not comments.
std::string with_short_lines(std::string text, const std::string& where) {
  if (!has_long_line(text)) return text;
  for_each_line(text, [&](std::string_view line, std::size_t line_number) {
    if (line.size() > max_line_bytes)
      throw Error(Code::file_too_large, where, "line " + std::to_string(line_number) + " has more than 131,072 bytes",
                  "give a text file of at most 1000 columns");
    return true;
  });
  return text;
}

/// Removes lines that hold only separators from the end, as spreadsheets write them.
std::string without_empty_end(std::string text) {
  const std::size_t last = text.find_last_not_of(" \t\r\n;,");
  const std::size_t end = last == std::string::npos ? 0 : text.find_first_of("\r\n", last);
  if (end != std::string::npos) text.resize(end);
  return text;
}

}  // namespace

CsvTable::CsvTable(std::string text, std::string where, std::optional<int> skip_lines, const std::string& section,
                   Warnings warnings, bool is_sheet)
    : where_(std::move(where)), is_sheet_(is_sheet), warnings_(std::move(warnings)) {
  if (skip_lines && *skip_lines < 0)
    throw Error(Code::setting_out_of_range, setting("skip_lines"), "is " + std::to_string(*skip_lines),
                "give 0 or more");
  text = with_plain_minus(with_plain_blanks(to_utf8(std::move(text), where_)));
  if (!section.empty()) text = only_section(text, section, where_);
  const std::size_t bytes = text.size();
  text_ = with_short_lines(without_empty_end(std::move(text)), where_);
  ends_in_line_ = text_.size() == bytes && !text_.ends_with('\n') && !text_.ends_with('\r');
  read_preamble(skip_lines);
  names_ = preamble_.names;
  check_columns(names_.size());
  has_header_ = !names_.empty();
  separator_ = find_separator();
  std::vector<std::string_view> cells;
  std::size_t last_line = 0;
  visit_lines([&](std::string_view line, std::size_t line_number) {
    const bool follows = line_number == last_line + 1;
    last_line = line_number;
    const bool may_begin = !follows || line.starts_with("Interval=") || (has_header_ && line == header_line_);
    if (may_begin && begins_another(line)) {
      if (skip_lines) return false;
      refuse_sections(line, line_number);
    }
    const std::string_view above =
        std::string_view(text_).substr(0, static_cast<std::size_t>(line.data() - text_.data()));
    if (!follows && rows_.empty() && header_lines_ == 0) read_comments(above, preamble_.rates, preamble_.units);
    if (names_.empty() && read_names(line, above)) return true;
    const bool is_last = line.data() + line.size() == text_.data() + text_.size();
    if (is_last && ends_in_line_ && is_cut(line)) {
      cut_line_ = line_number;
      add_info(warnings_, "last_line_cut",
               "the file ends in the middle of line " + std::to_string(line_number) + ": decid ignores this line");
      return false;
    }
    const bool fits =
        !rows_.empty() && is_plain_ && std::count(line.begin(), line.end(), separator_) + 1 == std::ssize(names_);
    if (!fits) {
      split(line, separator_, cells);
      if (rows_.empty() && header_lines_ == 1 && read_units(cells)) {
        ++header_lines_;
        return true;
      }
      check_row(cells, line_number);
    }
    add_row(line, cells);
    return true;
  });
  if (names_.size() == 1) keep_blank_lines();
  if (rows_.empty())
    throw Error(Code::file_empty, where_, "holds no lines of data", "give a CSV file with lines of numbers");
  if (has_header_) add_units(preamble_.units, names_);
}

void CsvTable::read_preamble(std::optional<int> skip_lines) {
  if (skip_lines) {
    preamble_ = preamble_behind(text_, static_cast<std::size_t>(*skip_lines));
    return;
  }
  preamble_ = find_preamble(text_);
  if (!preamble_.misfit.problem.empty())
    throw Error(Code::table_unclear, where_, preamble_.misfit.problem,
                preamble_.misfit.remedy + "; or give " + setting("skip_lines") + " " + std::to_string(preamble_.lines) +
                    ": the columns then have only numbers, which " + setting("column") + " and " + setting("unit") +
                    " refer to");
}

/// Sets the names by the table's first line, or by a comment above it. Returns true if the line is the header.
bool CsvTable::read_names(std::string_view line, std::string_view above) {
  std::vector<std::string> names;
  read_header(line, above, names);
  if (has_header_) {
    ++header_lines_;
    header_line_ = line;
    return true;
  }
  if (names.empty()) names = commented_names(above, separator_, names_.size());
  has_header_ = !names.empty();
  if (has_header_) names_ = std::move(names);
  return false;
}

void CsvTable::add_row(std::string_view line, const std::vector<std::string_view>& cells) {
  if (rows_.empty()) {
    // Names are often quoted when numbers are not. Rows are about as long as the first one.
    const std::string_view rest = std::string_view(text_).substr(static_cast<std::size_t>(line.data() - text_.data()));
    is_plain_ = is_plain(rest, separator_);
    rows_.reserve(std::min(max_rows, rest.size() / (line.size() + 1) + 1));
    if (!is_plain_) cells_.reserve(rows_.capacity() * names_.size());
  }
  rows_.push_back(line);
  if (!is_plain_) index_cells(cells);
  if (rows_.size() > max_rows)
    throw Error(Code::file_too_large, where_, "has more than 10 million rows", "cut it to one trial");
}

/// Makes the blank lines between the rows of one column rows without a value: each is a sample that was not written.
/// Ignores them if all rows have as many between them, as in files whose lines end in CR CR LF. Throws Error for other
/// files with more of them than half of the rows.
void CsvTable::keep_blank_lines() {
  std::vector<std::string_view> all;
  std::vector<Place> cells;
  std::size_t fewest = max_rows, most = 0;  // between two rows
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    const std::size_t before = all.size();
    const char* const end = row == 0 ? rows_[0].data() : rows_[row - 1].data() + rows_[row - 1].size();
    for_every_line({end, static_cast<std::size_t>(rows_[row].data() - end)},
                   [&](std::string_view line, std::size_t number) {
                     if (number > 1 && trim(line).empty()) all.push_back(line.substr(0, 0));
                     return all.size() < max_rows;
                   });
    if (row > 0) fewest = std::min(fewest, all.size() - before);
    most = std::max(most, all.size() - before);
    if (!is_plain_) {
      cells.resize(all.size());
      cells.push_back(cells_[row]);
    }
    all.push_back(rows_[row]);
  }
  if (most == 0 || fewest == most) return;
  if (2 * (all.size() - rows_.size()) > rows_.size())
    throw Error(Code::table_unclear, where_,
                "has " + counted(std::ssize(all) - std::ssize(rows_), "blank line") + " between " +
                    counted(std::ssize(rows_), "row") + " of one column",
                "delete blank lines that are not missing samples");
  if (all.size() > max_rows)
    throw Error(Code::file_too_large, where_, "has more than 10 million rows", "cut it to one trial");
  rows_ = std::move(all);
  if (!is_plain_) cells_ = std::move(cells);
}

/// Returns true for a line after a blank line that is not a row of the table: a section's name or a footer.
bool CsvTable::begins_another(std::string_view line) const {
  constexpr std::size_t rows_of_a_table = 3;
  if (rows_.size() < rows_of_a_table) return false;
  std::vector<std::string_view> cells, row;
  split(line, separator_, cells);
  split(rows_.front(), separator_, row);
  return (cells.size() == 1 && names_.size() > 1) || !may_follow(cells, row);
}

void CsvTable::refuse_sections(std::string_view line, std::size_t line_number) const {
  const std::vector<Section> sections = find_sections(text_);
  if (sections.size() > 1)
    throw Error(Code::recording_ambiguous, where_, "holds several tables: " + to_list(sections),
                "choose one with " + setting("section") +
                    ", by its name or number; or join them in one table if they are one recording");
  const bool is_left_out =
      sections.size() == 1 && sections[0].end <= static_cast<std::size_t>(line.data() - text_.data());
  throw Error(Code::table_unclear, where_,
              "other lines follow the table, from line " + std::to_string(line_number) + " on: '" +
                  std::string(line.substr(0, 40)) + "'",
              is_left_out ? setting("section") + " 1 reads only the table; or delete these lines"
                          : "delete these lines, " + std::string(is_sheet_ ? "" : "put # before them, ") + "or give " +
                                setting("skip_lines") + " N if the table begins below");
}

/// Returns true if the last line of the file lacks cells, or part of its last number.
bool CsvTable::is_cut(std::string_view line) const {
  constexpr std::size_t some = 20, rows_of_a_table = 3;
  std::vector<std::string_view> cells;
  split(line, separator_, cells);
  if (rows_.size() < rows_of_a_table || !is_value(cells[0])) return false;
  if (cells.size() != names_.size()) return cells.size() < names_.size();
  const std::string_view last = cells.back();
  // Programs that write a fixed number of decimals write the same number in each row. People do not.
  const auto decimals = [](std::string_view cell) {
    return cell.size() - std::min(cell.find_first_of(".,"), cell.size());
  };
  std::size_t usual = 0;
  for (std::size_t row = rows_.size() - std::min(some, rows_.size()); row < rows_.size(); ++row) {
    const std::string_view text = cell(row, cells.size() - 1);
    if (!parse_number(text).is_number || (usual != 0 && decimals(text) != usual)) return false;
    usual = decimals(text);
  }
  if (is_missing(last) && !last.empty() && last != "-") return false;  // a complete word
  return (rows_.size() >= some && decimals(last) < usual) || !parse_number(last).is_number;
}

/// Appends the places of the last row's cells.
void CsvTable::index_cells(const std::vector<std::string_view>& cells) {
  const char* const begin = rows_.back().data();
  for (std::size_t i = 0; i < names_.size(); ++i)
    cells_.push_back(
        {static_cast<std::uint32_t>(cells[i].data() - begin), static_cast<std::uint32_t>(cells[i].size())});
}

std::string_view CsvTable::cell(std::size_t row, std::size_t column) const {
  if (is_plain_) return plain_cell(rows_[row], separator_, column);
  const Place place = cells_[row * names_.size() + column];
  return rows_[row].substr(place.begin, place.length);
}

/// Throws Error unless the row has as many cells as the table, or one more that is empty.
void CsvTable::check_row(const std::vector<std::string_view>& cells, std::size_t line_number) const {
  const bool ends_in_separator = cells.size() == names_.size() + 1 && cells.back().empty();
  if (cells.size() == names_.size() || ends_in_separator) return;
  throw Error(
      Code::table_unclear, where_,
      "line " + std::to_string(line_number) + " has " + counted(std::ssize(cells), "column") +
          "; the lines before it have " + std::to_string(names_.size()) +
          (is_sheet_ ? "" : std::string(" (between ") + separators_called(separator_) + ", as in its first lines)"),
      "correct the line, " + how_to_leave_out() + ", or give " + setting("skip_lines") +
          " N if the table begins below");
}

void CsvTable::check_columns(std::size_t count) const {
  if (count > max_columns)
    throw Error(Code::file_too_large, where_, "has " + std::to_string(count) + " columns",
                "give a file of at most 1000");
}

/// Calls visit(line, number) for the lines of the table, its header first, until it returns false.
template <class Visit>
void CsvTable::visit_lines(const Visit& visit) const {
  for_each_line(text_, [&](std::string_view line, std::size_t line_number) {
    return line_number <= preamble_.lines || visit(line, line_number);
  });
}

char CsvTable::find_separator() const {
  // The second line decides: the first may be a header with any characters in its names.
  std::string_view first, last;
  int lines = 0;
  visit_lines([&](std::string_view candidate, std::size_t) {
    first = last;
    last = candidate;
    return ++lines < 2;
  });
  return guess_separator(first, last);
}

/// Returns true if the cells are a row that has words in some columns, not names: the row below has words and values in
/// the same columns.
bool CsvTable::is_row_with_words(const std::vector<std::string_view>& cells) const {
  if (std::ranges::any_of(cells, [](auto cell) { return is_text(cell) && is_known_name(cell); })) return false;
  std::vector<std::string_view> below;
  int lines = 0;
  visit_lines([&](std::string_view line, std::size_t) {
    split(line, separator_, below);
    return ++lines < 2;
  });
  while (below.size() > cells.size() && below.back().empty()) below.pop_back();
  return lines == 2 && std::ranges::equal(cells, below, {}, is_text, is_text);
}

/// Reads a line that is the header, or the first row. commented: receives the names of a comment above a row with
/// words.
void CsvTable::read_header(std::string_view line, std::string_view above, std::vector<std::string>& commented) {
  std::vector<std::string_view> cells;
  split(line, separator_, cells);
  while (cells.size() > 1 && cells.back().empty()) cells.pop_back();
  check_columns(cells.size());
  has_header_ = std::ranges::any_of(cells, is_text);
  if (has_header_ && std::ranges::any_of(cells, is_value)) {
    commented = commented_names(above, separator_, cells.size());
    has_header_ = commented.empty() && !is_row_with_words(cells);
  }
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const bool named = has_header_ && !cells[i].empty();
    names_.push_back(named ? std::string(cells[i]) : "column " + std::to_string(i + 1));
  }
}

/// Returns true and appends the cells to the names if the cells are units (are_units).
bool CsvTable::read_units(const std::vector<std::string_view>& cells) {
  if (cells.size() < names_.size() || !are_units(cells)) return false;
  for (std::size_t i = 0; i < names_.size(); ++i) names_[i] = with_unit(names_[i], cells[i]);
  return true;
}

double CsvTable::finite(const Parsed& parsed, std::string_view cell, int column, std::size_t row,
                        Missing missing) const {
  if (parsed.is_number && std::isfinite(parsed.value)) return parsed.value;
  if (missing == Missing::kept && is_missing(cell)) return std::numeric_limits<double>::quiet_NaN();
  throw Error(is_missing(cell) ? Code::value_missing : Code::value_invalid, where_,
              locate(row) + ", " + names_[static_cast<std::size_t>(column)] + ": " + shown(cell),
              is_missing(cell) ? remedy_for_missing : remedy_for_text(row));
}

/// Returns the advice about lines that are not data.
std::string CsvTable::how_to_leave_out() const {
  return is_sheet_ ? "delete rows that are not data" : "put # before lines that are not data";
}

/// Returns the advice about a cell that is a text. Rows without any number below the names are a second header, or a
/// note.
std::string CsvTable::remedy_for_text(std::size_t row) const {
  std::vector<std::string_view> cells;
  std::size_t without_numbers = 0;
  for (; has_header_ && without_numbers < rows_.size(); ++without_numbers) {
    split(rows_[without_numbers], separator_, cells);
    if (std::ranges::any_of(cells, is_value)) break;
  }
  if (row >= without_numbers) return "correct the cell, or " + how_to_leave_out();
  const std::size_t above = line_of(without_numbers - 1) - 1;
  return "if it is a second header, delete one of the two, or give " + setting("skip_lines") + " " +
         std::to_string(above) + " to leave out the lines above it; if not, " + how_to_leave_out();
}

/// Returns true if another column has decimal points in its first rows.
bool CsvTable::has_points_beside(int column) const {
  constexpr std::size_t some = 20;
  std::vector<std::string_view> cells;
  for (std::size_t row = 0; row < std::min(some, rows_.size()); ++row) {
    split(rows_[row], separator_, cells);
    for (std::size_t i = 0; i < cells.size(); ++i)
      if (std::cmp_not_equal(i, column) && has_decimal_point(cells[i])) return true;
  }
  return false;
}

/// Returns the meaning of commas within the column's cells. Throws Error if they are ambiguous.
Commas CsvTable::commas_in(int column) const {
  if ((is_plain_ && separator_ == ',') || text_.find(',') == text_.npos) return Commas::none;
  CommaFinder finder;
  std::size_t row = 0;
  for (; row < rows_.size(); ++row)
    if (finder.see(cell(row, static_cast<std::size_t>(column)))) break;
  const bool points = row == rows_.size() && !finder.example().empty() && has_points_beside(column);
  const Commas found = finder.found(points, separator_ == ',');
  if (found == Commas::unclear)
    throw Error(Code::table_unclear, where_,
                names_[static_cast<std::size_t>(column)] + ": '" + std::string(finder.example()) +
                    "' has a comma that may be a decimal one or one between thousands",
                "save it without separators between thousands, or with semicolons between cells");
  return found;
}

std::vector<double> CsvTable::numbers(int column, Missing missing) const {
  return numbers_of_each(column, 1, missing);
}

std::vector<double> CsvTable::numbers_of_each(int column, std::size_t step, Missing missing) const {
  const Commas commas = commas_in(column);
  std::vector<double> values;
  values.reserve(rows_.size() / step + 1);
  for (std::size_t row = 0; row < rows_.size(); row += step) {
    const std::string_view text = cell(row, static_cast<std::size_t>(column));
    values.push_back(finite(parse_number(text, commas), text, column, row, missing));
  }
  return values;
}

std::vector<double> CsvTable::times(int column) const {
  constexpr double day_s = 86400.0;
  const Commas commas = commas_in(column);
  std::vector<double> values;
  values.reserve(rows_.size());
  std::optional<double> first_day;
  double midnights = 0.0;  // midnights passed by times without a date
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    const std::string_view text = cell(row, static_cast<std::size_t>(column));
    const Parsed parsed = parse_number(text, commas);
    const std::optional<ClockTime> time = parsed.is_number ? std::nullopt : clock_time(text);
    if (time && !first_day) first_day = time->day;
    double value = time ? (time->day - *first_day + midnights) * day_s + time->s
                        : finite(parsed, text, column, row, Missing::refused);
    const bool has_date = time && time->day != 0.0;
    if (time && !has_date && !values.empty() && value < values.back() - 0.5 * day_s) {
      midnights += 1.0;
      value += day_s;
    }
    values.push_back(value);
  }
  if (const int nanoseconds = has_header_ ? nanoseconds_beside(names_, column) : -1; nanoseconds >= 0)
    add_nanoseconds(nanoseconds, values);
  return values;
}

/// Adds a column of nanoseconds to whole seconds. Does nothing if it is not of nanoseconds below a second.
void CsvTable::add_nanoseconds(int column, std::vector<double>& seconds) const {
  const auto is_whole = [](double value) { return value == std::floor(value); };
  if (!std::ranges::all_of(seconds, is_whole)) return;
  const std::vector<double> added = numbers(column);
  if (!std::ranges::all_of(added, [&](double value) { return value >= 0.0 && value < 1e9 && is_whole(value); })) return;
  for (std::size_t row = 0; row < seconds.size(); ++row) seconds[row] += 1e-9 * added[row];
}

RowLabels CsvTable::labels(int column) const {
  RowLabels labels;
  std::map<std::string_view, std::uint32_t> known;
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    const std::string_view text = cell(row, static_cast<std::size_t>(column));
    const auto [found, is_new] = known.try_emplace(text, static_cast<std::uint32_t>(labels.values.size()));
    if (is_new) labels.values.push_back(is_missing(text) ? std::string() : std::string(text));
    labels.of_row.push_back(found->second);
  }
  return labels;
}

std::string CsvTable::label(int column, std::size_t row) const {
  return std::string(cell(row, static_cast<std::size_t>(column)));
}

void CsvTable::keep_rows(int, const std::vector<std::size_t>& rows) {
  const std::size_t columns = is_plain_ ? 0 : names_.size();
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows_[i] = rows_[rows[i]];
    for (std::size_t c = 0; c < columns; ++c) cells_[i * columns + c] = cells_[rows[i] * columns + c];
  }
  rows_.resize(rows.size());
  cells_.resize(rows.size() * columns);
  number_kept_rows(rows);
}

void CsvTable::describe(std::vector<std::string> names, std::vector<StatedRate> rates) {
  has_header_ = true;
  names_ = std::move(names);
  preamble_.rates = std::move(rates);
}

std::string CsvTable::locate(std::size_t row) const {
  return "line " + std::to_string(line_of(row));
}

std::size_t CsvTable::line_of(std::size_t row) const {
  std::size_t found = 0;
  for_every_line(text_, [&](std::string_view line, std::size_t line_number) {
    found = line_number;
    return line.data() + line.size() < rows_[row].data();
  });
  return found;
}

}  // namespace decid::recording
