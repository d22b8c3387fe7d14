// Cells of a table: see cells.hpp. std::from_chars reads numbers the same way in every locale.
#include "recording/table/cells.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "base/number.hpp"
#include "base/text.hpp"
#include "recording/table/columns.hpp"
#include "recording/table/detail/thousands.hpp"

namespace decid::recording {

namespace {

/// Returns true for "1,5 2,7": every word is a number, and a digit follows each comma.
bool commas_are_decimal(std::string_view line) {
  bool any = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] != ',') continue;
    any = true;
    if (i + 1 == line.size() || line[i + 1] < '0' || line[i + 1] > '9') return false;
  }
  std::vector<std::string_view> cells;
  split(line, ' ', cells);
  return any &&
         std::all_of(cells.begin(), cells.end(), [](std::string_view cell) { return parse_number(cell).is_number; });
}

/// Returns a line without quoted text.
std::string outside_quotes(std::string_view line) {
  std::string outside;
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') quoted = !quoted;
    if (c == '"' || !quoted) outside += c;
  }
  return outside;
}

}  // namespace

std::string_view trim(std::string_view text) {
  const auto is_blank = [](char c) { return c == ' ' || c == '\t'; };
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

std::size_t line_ends(std::string_view text) {
  return static_cast<std::size_t>(std::ranges::count(text, text.find('\n') == text.npos ? '\r' : '\n'));
}

void split(std::string_view line, char separator, std::vector<std::string_view>& cells) {
  cells.clear();
  if (is_plain(line, separator)) {
    for (std::size_t end = line.find(separator); end != line.npos; end = line.find(separator)) {
      cells.push_back(trim(line.substr(0, end)));
      line.remove_prefix(end + 1);
    }
    cells.push_back(trim(line));
    return;
  }
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

bool is_plain(std::string_view text, char separator) {
  return separator != ' ' && text.find('"') == text.npos;
}

std::string_view plain_cell(std::string_view line, char separator, std::size_t column) {
  for (; column > 0; --column) line.remove_prefix(line.find(separator) + 1);
  return trim(line.substr(0, line.find(separator)));
}

namespace {

Parsed parse_with_point(std::string_view cell) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error == std::errc::invalid_argument || end != cell.data() + cell.size()) return {false, 0.0};
  return {true, error == std::errc() ? value : std::numeric_limits<double>::infinity()};
}

/// Returns "1.0e-03" for "1.0D-03", Fortran's double precision. Empty for other text: a Fortran mantissa has a point,
/// so "3D" and "2d1" stay words.
std::string with_c_exponent(std::string_view cell) {
  const std::size_t letter = cell.find_first_of("Dd");
  if (letter == cell.npos || cell.substr(0, letter).find('.') == cell.npos) return {};
  std::string number(cell);
  number[letter] = 'e';
  return number;
}

}  // namespace

Parsed parse_number(std::string_view cell) {
  if (cell.starts_with('+') && !cell.starts_with("+-")) cell.remove_prefix(1);
  const Parsed parsed = parse_with_point(cell);
  if (parsed.is_number) return parsed;
  if (const std::string fortran = with_c_exponent(cell); !fortran.empty()) return parse_with_point(fortran);
  if (is_plainly_grouped(cell)) {
    for (const char group : {',', '.', '\''})
      if (const std::optional<double> value = grouped(cell, group)) return {true, *value};
  }
  const std::size_t comma = cell.find(',');
  if (comma == std::string_view::npos || cell.find('.') != std::string_view::npos) return parsed;
  std::string with_point(cell);
  with_point[comma] = '.';
  return parse_with_point(with_point);
}

Parsed parse_number(std::string_view cell, Commas commas) {
  const bool decimal = commas == Commas::decimal && cell.find('.') != std::string_view::npos;
  const bool thousands = commas == Commas::thousands && cell.find(',') != std::string_view::npos;
  if (decimal || thousands) {
    if (const std::optional<double> value = grouped(cell, decimal ? '.' : ',')) return {true, *value};
    if (thousands) return {false, 0.0};
  }
  return parse_number(cell);
}

bool is_missing(std::string_view cell) {
  return one_of(lower_case(std::string(cell)),
                {"", "nan", "-nan", "na", "n/a", "null", "none", "missing", "?", "-", "--", "---", ".", "#n/a", "#nv"});
}

bool is_comment(std::string_view line) {
  line = trim(line);
  if (line.starts_with('%')) return true;
  return line.starts_with('#') && !is_missing(line.substr(0, line.find_first_of(",;|\t ")));
}

std::optional<std::string> unit_of_cell(std::string_view cell) {
  if (cell.size() >= 2 && (cell.front() == '[' || cell.front() == '(')) {
    if (cell.back() != (cell.front() == '[' ? ']' : ')')) return {};
    cell = trim(cell.substr(1, cell.size() - 2));
  }
  const std::string as_written(cell), unit = lower_case(as_written);
  const bool known =
      one_of(unit, {"",           "s",         "sec",         "seconds", "sek",   "sekunden", "ms",   "us",    "deg",
                    "degree",     "degrees",   "\xC2\xB0",    "grad",    "rad",   "mrad",     "mm",   "cm",    "m",
                    "n",          "nm",        "n*m",         "n.m",     "n m",   "v",        "mv",   "hz",    "kg",
                    "deg/s",      "g",         "rad/s",       "m/s^2",   "m/s2",  "m/s",      "%",    "a.u.",  "counts",
                    "uv",         "\xC2\xB5v", "kn",          "n.mm",    "nmm",   "n*mm",     "n mm", "pa",    "kpa",
                    "w",          "j",         "khz",         "bpm",     "msecs", "msec",     "n/kg", "nm/kg", "volts",
                    "kg*m/s",     "c",         "\u00B0c",     "gauss",   "ut",    "w/kg",     "1",    "-",     "grad/s",
                    "\xC2\xB0/s", "min",       "hh:mm:ss.ms", "hh:mm:ss"});
  if (!known) return {};
  return as_written;
}

bool are_units(const std::vector<std::string_view>& cells) {
  std::size_t known = 0, empty = 0;
  for (const std::string_view cell : cells) {
    const std::optional<std::string> unit = unit_of_cell(cell);
    if (cell.empty()) {
      ++empty;
    } else if (unit && !parse_number(*unit).is_number) {
      ++known;
    } else if (!unit &&
               (cell.size() > 8 || cell.find(' ') != cell.npos || clock_time(cell) || parse_number(cell).is_number ||
                is_missing(cell) || (cell.front() >= '0' && cell.front() <= '9') || cell.front() == '[')) {
      return false;
    }
  }
  return known > 0 && 2 * (known + empty) >= cells.size();
}

std::string with_unit(std::string name, std::string_view unit) {
  const std::string plain = unit_of_cell(unit).value_or(std::string(unit));
  if (!one_of(plain, {"", "-", "1"})) name += " (" + plain + ")";
  return name;
}

char guess_separator(std::string_view line_before, std::string_view data) {
  const std::string_view first = trim(line_before);
  const std::string unquoted = outside_quotes(data);
  const std::string_view line = trim(unquoted);
  for (const char separator : {';', '\t', '|'}) {
    if (line.find(separator) != std::string_view::npos) return separator;
  }
  const bool blanks = line.find(' ') != std::string_view::npos;
  if (line.find(',') == std::string_view::npos) return blanks && !clock_time(line) ? ' ' : ',';
  // One number with a decimal comma below a header of one name, or several numbers between blanks.
  const bool one_column = !first.empty() && first.find_first_of(", ") == std::string_view::npos &&
                          !parse_number(first).is_number && std::count(line.begin(), line.end(), ',') == 1;
  return (blanks || one_column) && commas_are_decimal(trim(data)) ? ' ' : ',';
}

namespace {

/// Reads as many whole numbers between separators as `into` has: "12:03" into two. Returns false for other text.
template <std::size_t N>
bool whole_numbers(std::string_view text, char separator, std::array<int, N>& into) {
  for (std::size_t i = 0; i < N; ++i) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), into[i]);
    if (error != std::errc() || into[i] < 0) return false;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    if (i + 1 == N) return text.empty();
    if (text.empty() || text.front() != separator) return false;
    text.remove_prefix(1);
  }
  return true;
}

/// Returns the number of a month by its first three letters in English, as MATLAB writes it; 0 for other text.
int month_of(std::string_view name) {
  constexpr std::string_view names = "JanFebMarAprMayJunJulAugSepOctNovDec";
  const std::size_t at = name.size() == 3 ? names.find(name) : names.npos;
  return at == names.npos || at % 3 != 0 ? 0 : static_cast<int>(at / 3) + 1;
}

/// Replaces the month's letters in "01-May-2023" by its number and puts the year first; keeps other text.
std::string with_number_of_month(std::string_view date) {
  const std::size_t first = date.find('-'), last = date.rfind('-');
  const int month = first == date.npos || first == last ? 0 : month_of(date.substr(first + 1, last - first - 1));
  if (month == 0) return std::string(date);
  return std::string(date.substr(last + 1)) + "-" + std::to_string(month) + "-" + std::string(date.substr(0, first));
}

/// Reads "0.01 sec" and "0.5 min", as MATLAB writes durations.
std::optional<ClockTime> duration(std::string_view cell) {
  for (const auto& [unit, unit_s] : {std::pair{" sec", 1.0}, {" min", 60.0}}) {
    if (!cell.ends_with(unit)) continue;
    const Parsed parsed = parse_number(cell.substr(0, cell.size() - 4));
    if (parsed.is_number && std::isfinite(parsed.value)) return ClockTime{0.0, parsed.value * unit_s};
  }
  return {};
}

/// Returns the days since the first of March of year 0 of the Gregorian calendar. Years count from March, so that their
/// months have 153 days in five.
std::optional<double> days(std::string_view date) {
  std::array<int, 3> parts{};  // year, month, day
  if (whole_numbers(date, '.', parts)) {
    std::swap(parts[0], parts[2]);
  } else if (whole_numbers(date, '/', parts)) {
    if (parts[0] < 1000) parts = {parts[2], parts[0], parts[1]};  // month/day/year
  } else if (!whole_numbers(date, '-', parts)) {
    return {};
  }
  if (parts[0] > 9999 || parts[1] < 1 || parts[1] > 12 || parts[2] < 1 || parts[2] > 31) return {};
  const int month = (parts[1] + 9) % 12, year = parts[0] - (parts[1] < 3 ? 1 : 0);
  return 365 * year + year / 4 - year / 100 + year / 400 + (153 * month + 2) / 5 + parts[2] - 1;
}

/// Removes " PM" or " am". Returns true for the afternoon, nothing if the cell has neither.
std::optional<bool> take_afternoon(std::string_view& cell) {
  for (const auto& [end, afternoon] : {std::pair{"am", false}, {"pm", true}, {"AM", false}, {"PM", true}}) {
    if (!cell.ends_with(end)) continue;
    cell = trim(cell.substr(0, cell.size() - 2));
    return afternoon;
  }
  return {};
}

/// Removes a time zone: "+00:00", "-05:30" or "Z". All times of a recording have the same one.
void take_offset(std::string_view& cell) {
  if (cell.ends_with('Z')) cell.remove_suffix(1);
  const std::size_t sign = cell.find_last_of("+-");
  std::array<int, 2> parts{};
  if (sign != std::string_view::npos && sign > 5 && whole_numbers(cell.substr(sign + 1), ':', parts))
    cell = cell.substr(0, sign);
}

}  // namespace

std::optional<ClockTime> clock_time(std::string_view cell) {
  if (cell.find(':') == std::string_view::npos) return duration(cell);
  double day = 0.0;
  const std::optional<bool> afternoon = take_afternoon(cell);
  if (const std::size_t count = cell.find(" days "); count != std::string_view::npos) {  // a timedelta of pandas
    const Parsed days_passed = parse_number(cell.substr(0, count));
    if (!days_passed.is_number) return {};
    day = days_passed.value;
    cell = trim(cell.substr(count + 6));
  } else if (const std::size_t blank = cell.find_first_of(" T"); blank != std::string_view::npos) {
    const std::optional<double> found = days(with_number_of_month(cell.substr(0, blank)));
    if (!found) return {};
    day = *found;
    cell = trim(cell.substr(blank + 1));
  }
  take_offset(cell);
  double fraction = 0.0;
  // "12:03:04:250": some programs write milliseconds this way
  const std::size_t last = cell.rfind(':');
  const bool has_milliseconds = std::count(cell.begin(), cell.end(), ':') == 3 && cell.size() - last == 4;
  const std::size_t point = has_milliseconds ? last : cell.find_first_of(".,");
  if (point != std::string_view::npos) {
    const std::string digits = "0." + std::string(cell.substr(point + 1));
    const std::optional<double> read = number_from<double>(digits);
    if (!read || digits.find_first_of("eE") != digits.npos) return {};
    fraction = *read;
    cell = cell.substr(0, point);
  }
  std::array<int, 3> parts{};  // hours, minutes, seconds
  // "03:04.5" is minutes and seconds; "03:04" is ambiguous.
  if (std::array<int, 2> two{}; point != std::string_view::npos && whole_numbers(cell, ':', two) && two[1] <= 59)
    return ClockTime{day, 60.0 * two[0] + two[1] + fraction};
  if (!whole_numbers(cell, ':', parts) || parts[0] > 24 || parts[1] > 59 || parts[2] > 60) return {};
  if (afternoon) parts[0] = parts[0] % 12 + (*afternoon ? 12 : 0);
  return ClockTime{day, 3600.0 * parts[0] + 60.0 * parts[1] + parts[2] + fraction};
}

bool is_value(std::string_view cell) {
  return parse_number(cell).is_number || clock_time(cell);
}

}  // namespace decid::recording
