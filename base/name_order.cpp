// The order of names that contain numbers: see name_order.hpp.
#include "base/name_order.hpp"

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/number.hpp"

namespace decid {
namespace {

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

std::size_t end_of_digits(std::string_view text, std::size_t from) {
  while (from < text.size() && is_digit(text[from])) ++from;
  return from;
}

/// Returns the end of the number whose digits begin at `from`. Parts of a date, 1.10.2024, are numbers of their own.
std::size_t end_of_number(std::string_view text, std::size_t from) {
  const auto is_point = [&](std::size_t i) { return i < text.size() && (text[i] == '.' || text[i] == ','); };
  const std::size_t whole = end_of_digits(text, from);
  if (!is_point(whole) || (from > 0 && is_point(from - 1))) return whole;
  const std::size_t end = end_of_digits(text, whole + 1);
  return end == whole + 1 || is_point(end) ? whole : end;
}

double value_of(std::string_view digits) {
  std::string text(digits);
  if (const std::size_t comma = text.find(','); comma != std::string::npos) text[comma] = '.';
  return number_from<double>(text).value_or(std::numeric_limits<double>::infinity());
}

/// A date whose year comes last.
struct Date {
  std::array<int, 2> numbers;  ///< day and month, or with slashes and hyphens perhaps month and day
  int year;
  char separator;
  std::size_t end;  ///< in the name

  bool is_month_first() const { return separator != '.' && numbers[1] > 12; }
};

/// Returns the date that begins at `from`, if there is one.
std::optional<Date> date_at(std::string_view text, std::size_t from) {
  Date date{};
  std::size_t at = from;
  for (int& number : date.numbers) {
    const std::size_t end = end_of_digits(text, at);
    if (end == at || end > at + 2 || end == text.size()) return {};
    number = number_from<int>(text.substr(at, end - at)).value_or(0);
    if (at == from) date.separator = text[end];
    if (text[end] != date.separator) return {};
    at = end + 1;
  }
  date.end = end_of_digits(text, at);
  const std::size_t digits = date.end - at;
  if (date.separator != '.' && date.separator != '/' && date.separator != '-') return {};
  const bool is_short = digits == 2 && date.separator == '.' && at == from + 6;  // 31.03.24, and not chapter 1.2.10
  if (digits != 4 && !is_short) return {};
  const auto joins_number = [&](std::size_t place, std::size_t next) {  // as in 1.10.3.2024
    return place < text.size() && text[place] == date.separator && next < text.size() && is_digit(text[next]);
  };
  if (joins_number(date.end, date.end + 1) || (from > 1 && joins_number(from - 1, from - 2))) return {};
  date.year = number_from<int>(text.substr(at, digits)).value_or(0);
  if (digits == 2) date.year += date.year < 70 ? 2000 : 1900;
  const int month = date.numbers[date.is_month_first() ? 0 : 1], day = date.numbers[date.is_month_first() ? 1 : 0];
  if (month < 1 || month > 12 || day < 1 || day > 31) return {};
  return date;
}

/// Returns the parts of a name in their order. A part is a character, or a number with its value; the first number of
/// each pair orders characters, and negative numbers before others.
std::vector<std::pair<int, double>> parts_of(std::string_view text) {
  std::vector<std::pair<int, double>> parts;
  for (std::size_t i = 0; i < text.size();) {
    const bool is_negative =
        text[i] == '-' && i + 1 < text.size() && is_digit(text[i + 1]) && (i == 0 || text[i - 1] == ' ');
    if (!is_negative && !is_digit(text[i])) {
      parts.emplace_back(2 * static_cast<unsigned char>(text[i++]), 0.0);
      continue;
    }
    if (const std::optional<Date> date = is_negative ? std::nullopt : date_at(text, i)) {
      const auto [first, second] = date->numbers;
      const bool is_month_first = date->is_month_first();
      parts.emplace_back(2 * '0', date->year);  // as the parts of 2024-03-31
      for (const int number : {is_month_first ? first : second, is_month_first ? second : first}) {
        parts.emplace_back(2 * '-', 0.0);
        parts.emplace_back(2 * '0', number);
      }
      i = date->end;
      continue;
    }
    const std::size_t from = i + (is_negative ? 1U : 0U);
    i = end_of_number(text, from);
    const double value = value_of(text.substr(from, i - from));
    parts.emplace_back(is_negative ? 2 * '-' - 1 : 2 * '0', is_negative ? -value : value);
  }
  return parts;
}

}  // namespace

DayMonth day_month_of(std::string_view name) {
  const std::optional<Date> date = date_at(name, 0);
  if (!date || date->end != name.size() || date->separator == '.' || date->numbers[0] == date->numbers[1])
    return DayMonth::none;
  if (date->is_month_first()) return DayMonth::month_first;
  return date->numbers[0] > 12 ? DayMonth::day_first : DayMonth::unclear;
}

bool are_equal_in_order(std::string_view a, std::string_view b) {
  return parts_of(a) == parts_of(b);
}

bool NameOrder::operator()(std::string_view a, std::string_view b) const {
  const std::vector<std::pair<int, double>> of_a = parts_of(a), of_b = parts_of(b);
  return of_a == of_b ? a < b : of_a < of_b;
}

}  // namespace decid
