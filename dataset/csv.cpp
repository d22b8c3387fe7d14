// Tables of numbers as text. One pass finds the separator, one counts rows and checks their length, one more for each
// column parses its numbers: memory is the text and the columns asked for.
// Numbers by std::from_chars: the same in every locale.
#include "dataset/csv.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "base/error.hpp"

namespace decid::dataset {

namespace {

constexpr std::size_t row_limit = 10'000'000;
constexpr std::size_t column_limit = 1000;

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

Parsed parse(std::string_view cell, char separator) {
  if (cell.starts_with('+') && !cell.starts_with("+-")) cell.remove_prefix(1);
  std::string with_point;
  if (separator != ',' && cell.find('.') == std::string_view::npos) {
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
    const bool ends_in_separator = cells.size() == names_.size() + 1 && cells.back().empty();
    if (cells.size() != names_.size() && !ends_in_separator) {
      throw Error(where_,
                  "line " + std::to_string(line_number) + " has " + std::to_string(cells.size()) +
                      " columns, the lines before it " + std::to_string(names_.size()),
                  "correct the line, or put # before lines that are not data");
    }
    if (++rows_ > row_limit) {
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
    std::size_t end = text.find_first_of("\r\n", begin);
    if (end == std::string_view::npos) end = text.size();
    const std::string_view line = text.substr(begin, end - begin);
    begin = end + (text.substr(end, 2) == "\r\n" ? 2 : 1);
    ++line_number;
    const std::string_view content = trim(line);
    if (content.empty() || content.front() == '#' || content.front() == '%') continue;
    if (!visit(line, line_number)) return;
  }
}

char CsvTable::find_separator() const {
  // The second line tells better than the first, which may be a header with anything in its names.
  std::string_view line;
  int lines = 0;
  for_each_line([&](std::string_view candidate, std::size_t) {
    line = candidate;
    return ++lines < 2;
  });
  line = trim(line);
  for (const char separator : {';', '\t', ','}) {
    if (line.find(separator) != std::string_view::npos) return separator;
  }
  return line.find(' ') != std::string_view::npos ? ' ' : ',';
}

void CsvTable::read_header(std::string_view line) {
  std::vector<std::string_view> cells;
  split(line, separator_, cells);
  while (cells.size() > 1 && cells.back().empty()) cells.pop_back();
  if (cells.size() > column_limit) {
    throw Error(where_, "has " + std::to_string(cells.size()) + " columns", "at most 1000 can be read");
  }
  has_header_ = std::any_of(cells.begin(), cells.end(),
                            [&](std::string_view cell) { return !cell.empty() && !parse(cell, separator_).is_number; });
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const bool named = has_header_ && !cells[i].empty();
    names_.push_back(named ? std::string(cells[i]) : "column " + std::to_string(i + 1));
  }
}

double CsvTable::number(std::string_view cell, int column, std::size_t line) const {
  const Parsed parsed = parse(cell, separator_);
  if (parsed.is_number && std::isfinite(parsed.value)) return parsed.value;
  throw Error(where_,
              "line " + std::to_string(line) + ", " + names_[static_cast<std::size_t>(column)] + ": " + shown(cell),
              "correct the cell, or put # before lines that are not data");
}

std::vector<double> CsvTable::numbers(int column) const {
  std::vector<double> values;
  values.reserve(rows_);
  std::vector<std::string_view> cells;
  bool header = has_header_;
  for_each_line([&](std::string_view line, std::size_t line_number) {
    if (std::exchange(header, false)) return true;
    split(line, separator_, cells);
    values.push_back(number(cells[static_cast<std::size_t>(column)], column, line_number));
    return true;
  });
  return values;
}

std::size_t CsvTable::line_of(std::size_t row) const {
  std::size_t found = 0, lines = row + (has_header_ ? 2 : 1);
  for_each_line([&](std::string_view, std::size_t line_number) {
    found = line_number;
    return --lines > 0;
  });
  return found;
}

}  // namespace decid::dataset
