// The order of names that contain numbers: see name_order.hpp.
#include "base/name_order.hpp"

#include <cstddef>
#include <limits>
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
    const std::size_t from = i + (is_negative ? 1U : 0U);
    i = end_of_number(text, from);
    const double value = value_of(text.substr(from, i - from));
    parts.emplace_back(is_negative ? 2 * '-' - 1 : 2 * '0', is_negative ? -value : value);
  }
  return parts;
}

}  // namespace

bool NameOrder::operator()(std::string_view a, std::string_view b) const {
  const std::vector<std::pair<int, double>> of_a = parts_of(a), of_b = parts_of(b);
  return of_a == of_b ? a < b : of_a < of_b;
}

}  // namespace decid
