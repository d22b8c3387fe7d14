// Tables of numbers as text. One pass finds the separator, one counts rows and checks their length, one more for each
// column parses its numbers: memory is the text and the columns asked for.
// Numbers by std::from_chars: the same in every locale.
#include "dataset/recording/csv.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "base/error.hpp"
#include "base/text.hpp"
#include "dataset/recording/columns.hpp"

namespace decid::dataset {

namespace {

std::string_view trim(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

/// The cells of a line, without blanks and quotes around them.
void split(std::string_view line, char separator, std::vector<std::string_view>& cells) {
  cells.clear();
  if (separator == ' ') line = trim(line);
  bool quoted = false;
  std::size_t begin = 0;
  for (std::size_t i = 0; i <= line.size(); ++i) {
    if (i < line.size() && line[i] == '"') quoted = !quoted;
    if (i < line.size() && (quoted || line[i] != separator)) continue;
    std::string_view cell = trim(line.substr(begin, i - begin));
    begin = i + 1;
    if (separator == ' ' && cell.empty()) continue;  // a run of blanks separates once
    if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"') cell = trim(cell.substr(1, cell.size() - 2));
    cells.push_back(cell);
  }
}

struct Parsed {
  bool is_number;  ///< also if it is not finite, or too large for a double
  double value;
};

/// A comma in a cell is a decimal one: a separator would have ended the cell.
Parsed parse(std::string_view cell) {
  if (cell.starts_with('+') && !cell.starts_with("+-")) cell.remove_prefix(1);
  std::string with_point;
  if (cell.find('.') == std::string_view::npos) {
    if (const std::size_t comma = cell.find(','); comma != std::string_view::npos) {
      with_point.assign(cell);
      with_point[comma] = '.';
      cell = with_point;
    }
  }
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error == std::errc::invalid_argument || end != cell.data() + cell.size()) return {false, 0.0};
  return {true, error == std::errc() ? value : std::numeric_limits<double>::infinity()};
}

/// "1,5 2,7": every word is a number, and a digit follows each comma.
bool commas_are_decimal(std::string_view line) {
  bool any = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] != ',') continue;
    any = true;
    if (i + 1 == line.size() || line[i + 1] < '0' || line[i + 1] > '9') return false;
  }
  std::vector<std::string_view> cells;
  split(line, ' ', cells);
  return any && std::all_of(cells.begin(), cells.end(), [](std::string_view cell) { return parse(cell).is_number; });
}

/// A line without what stands between quotes.
std::string outside_quotes(std::string_view line) {
  std::string outside;
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') quoted = !quoted;
    if (c == '"' || !quoted) outside += c;
  }
  return outside;
}

bool is_missing(std::string_view cell) {
  std::string lower(cell);
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return one_of(lower, {"", "nan", "-nan", "na", "n/a", "null", "-"});
}

/// Without the brackets that units are often put in: "[deg]".
std::string_view bare_unit(std::string_view cell) {
  if (cell.size() >= 2 && (cell.front() == '[' || cell.front() == '(')) cell = cell.substr(1, cell.size() - 2);
  return cell;
}

std::string shown(std::string_view cell) {
  if (cell.empty()) return "the cell is empty";
  if (cell.size() > 40) return "'" + std::string(cell.substr(0, 37)) + "...' is not a finite number";
  return "'" + std::string(cell) + "' is not a finite number";
}

}  // namespace

CsvTable::CsvTable(std::string text, std::string where) : text_(std::move(text)), where_(std::move(where)) {
  if (text_.starts_with("\xEF\xBB\xBF")) text_.erase(0, 3);
  if (text_.find('\0') != std::string::npos) {
    throw Error(where_, "is not a text file in UTF-8", "save it as CSV in UTF-8");
  }
  separator_ = find_separator();
  std::vector<std::string_view> cells;
  for_each_line([&](std::string_view line, std::size_t line_number) {
    if (names_.empty()) {
      read_header(line);
      if (has_header_) return true;
    }
    split(line, separator_, cells);
    if (rows_ == 0 && has_header_ && !has_units_ && read_units(cells)) return true;
    const bool ends_in_separator = cells.size() == names_.size() + 1 && cells.back().empty();
    if (cells.size() != names_.size() && !ends_in_separator) {
      const char* const between = separator_ == ';'    ? "semicolons"
                                  : separator_ == '\t' ? "tabs"
                                  : separator_ == ' '  ? "blanks"
                                                       : "commas";
      throw Error(where_,
                  "line " + std::to_string(line_number) + " has " + counted(std::ssize(cells), "column") +
                      ", the lines before it " + std::to_string(names_.size()) + " (between " + between +
                      ", as in its first lines)",
                  "correct the line, or put # before lines that are not data");
    }
    if (++rows_ > most_rows) {
      throw Error(where_, "has more than 10 million rows", "cut it to the trial to be identified");
    }
    return true;
  });
  if (rows_ == 0) throw Error(where_, "holds no lines of data", "give a CSV file with lines of numbers");
}

/// Calls visit(line, number) for every line that is neither blank nor a comment, until it returns false.
template <class Visit>
void CsvTable::for_each_line(const Visit& visit) const {
  const std::string_view text = text_;
  std::size_t line_number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    std::size_t end = begin;
    while (end < text.size() && text[end] != '\n' && text[end] != '\r') ++end;
    const std::string_view line = text.substr(begin, end - begin);
    begin = end + (text.substr(end, 2) == "\r\n" ? 2 : 1);
    ++line_number;
    const std::string_view content = trim(line);
    if (content.empty() || content.front() == '#' || content.front() == '%') continue;
    if (!visit(line, line_number)) return;
  }
}

char CsvTable::find_separator() const {
  // The second line is the better witness: the first may be a header with anything in its names.
  std::string_view first, last;
  int lines = 0;
  for_each_line([&](std::string_view candidate, std::size_t) {
    first = last;
    last = candidate;
    return ++lines < 2;
  });
  first = trim(first);
  const std::string unquoted = outside_quotes(last);
  const std::string_view line = trim(unquoted);
  for (const char separator : {';', '\t'}) {
    if (line.find(separator) != std::string_view::npos) return separator;
  }
  const bool blanks = line.find(' ') != std::string_view::npos;
  if (line.find(',') == std::string_view::npos) return blanks ? ' ' : ',';
  // One number with a decimal comma below a header of one name, or several of them between blanks.
  const bool one_column = !first.empty() && first.find_first_of(", ") == std::string_view::npos &&
                          !parse(first).is_number && std::count(line.begin(), line.end(), ',') == 1;
  return (blanks || one_column) && commas_are_decimal(trim(last)) ? ' ' : ',';
}

void CsvTable::read_header(std::string_view line) {
  std::vector<std::string_view> cells;
  split(line, separator_, cells);
  while (cells.size() > 1 && cells.back().empty()) cells.pop_back();
  if (cells.size() > most_columns) {
    throw Error(where_, "has " + std::to_string(cells.size()) + " columns", "at most 1000 can be read");
  }
  has_header_ = std::any_of(cells.begin(), cells.end(),
                            [&](std::string_view cell) { return !cell.empty() && !parse(cell).is_number; });
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const bool named = has_header_ && !cells[i].empty();
    names_.push_back(named ? std::string(cells[i]) : "column " + std::to_string(i + 1));
  }
}

/// True if the cells are units, every one of them; they are then put behind the names.
bool CsvTable::read_units(const std::vector<std::string_view>& cells) {
  const auto known = [](std::string_view unit) {
    return one_of(unit,
                  {"s",     "sec", "seconds", "ms",    "us",   "deg", "degree", "degrees", "\xC2\xB0", "rad", "mm",
                   "cm",    "m",   "n",       "nm",    "n*m",  "n.m", "n m",    "v",       "mv",       "hz",  "kg",
                   "deg/s", "g",   "rad/s",   "m/s^2", "m/s2", "m/s", "%",      "a.u.",    "counts",   "1",   "-"});
  };
  bool any = false;
  for (const std::string_view cell : cells) {
    std::string unit(bare_unit(cell));
    for (char& c : unit) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    if (unit.empty()) continue;
    if (!known(unit)) return false;
    any = any || !parse(cell).is_number;
  }
  if (!any || cells.size() < names_.size()) return false;
  for (std::size_t i = 0; i < names_.size(); ++i) {
    const std::string unit(bare_unit(cells[i]));
    if (!unit.empty() && unit != "-" && unit != "1") names_[i] += " (" + unit + ")";
  }
  return has_units_ = true;
}

double CsvTable::number(std::string_view cell, int column, std::size_t line, Missing missing) const {
  const Parsed parsed = parse(cell);
  if (parsed.is_number && std::isfinite(parsed.value)) return parsed.value;
  if (missing == Missing::kept && is_missing(cell)) return std::numeric_limits<double>::quiet_NaN();
  throw Error(where_,
              "line " + std::to_string(line) + ", " + names_[static_cast<std::size_t>(column)] + ": " + shown(cell),
              is_missing(cell) ? remedy_for(missing) : "correct the cell, or put # before lines that are not data");
}

std::vector<double> CsvTable::numbers(int column, Missing missing) const {
  std::vector<double> values;
  values.reserve(rows_);
  std::vector<std::string_view> cells;
  int skipped = (has_header_ ? 1 : 0) + (has_units_ ? 1 : 0);
  for_each_line([&](std::string_view line, std::size_t line_number) {
    if (skipped-- > 0) return true;
    skipped = 0;
    split(line, separator_, cells);
    values.push_back(number(cells[static_cast<std::size_t>(column)], column, line_number, missing));
    return true;
  });
  return values;
}

std::string CsvTable::place_of(std::size_t row) const {
  std::size_t found = 0, lines = row + 1 + (has_header_ ? 1 : 0) + (has_units_ ? 1 : 0);
  for_each_line([&](std::string_view, std::size_t line_number) {
    found = line_number;
    return --lines > 0;
  });
  return "line " + std::to_string(found);
}

}  // namespace decid::dataset
