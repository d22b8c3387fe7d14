// Numbers in groups of three digits: see thousands.hpp.
#include "recording/table/detail/thousands.hpp"

#include <algorithm>
#include <string>

#include "base/number.hpp"
#include "recording/table/cells.hpp"

namespace decid::recording {

namespace {

bool all_digits(std::string_view text) {
  return std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

std::string_view without_sign(std::string_view cell) {
  if (!cell.empty() && (cell.front() == '-' || cell.front() == '+')) cell.remove_prefix(1);
  return cell;
}

}  // namespace

std::optional<double> grouped(std::string_view cell, char group) {
  const std::string_view digits = without_sign(cell);
  const std::size_t point = digits.find(group == ',' ? '.' : group == '.' ? ',' : '.');
  std::string_view whole = digits.substr(0, point);
  const std::string_view fraction = point < digits.size() ? digits.substr(point + 1) : std::string_view();
  const std::size_t first = whole.find(group);
  if (first == 0 || first > 3 || whole.front() == '0' || !all_digits(fraction)) return {};
  std::string plain = cell.front() == '-' ? "-" : "";
  plain += whole.substr(0, first);
  if (!all_digits(whole.substr(0, first))) return {};
  for (whole.remove_prefix(first); !whole.empty(); whole.remove_prefix(4)) {
    if (whole.size() < 4 || whole.front() != group || !all_digits(whole.substr(1, 3))) return {};
    plain += whole.substr(1, 3);
  }
  plain += '.';
  plain += fraction;
  return number_from<double>(plain).value_or(0.0);
}

bool is_plainly_grouped(std::string_view cell) {
  for (const char group : {',', '.', '\''}) {
    if (!grouped(cell, group)) continue;
    const bool has_decimals = cell.find(group == ',' ? '.' : group == '.' ? ',' : '.') != std::string_view::npos;
    return group == '\'' || has_decimals || std::ranges::count(cell, group) > 1;
  }
  return false;
}

bool has_decimal_point(std::string_view cell) {
  return cell.find('.') != std::string_view::npos && cell.find(',') == std::string_view::npos && !grouped(cell, '.') &&
         parse_number(cell).is_number;
}

bool CommaFinder::see(std::string_view cell) {
  if (cell.find(',') == std::string_view::npos) {
    other_numbers_ = other_numbers_ || cell.find_first_of("123456789") != std::string_view::npos;
    return false;
  }
  if (grouped(cell, ',') && !is_plainly_grouped(cell)) {
    if (example_.empty()) example_ = cell;
  } else if (parse_number(cell).is_number) {
    plain_ = grouped(cell, ',') ? Commas::thousands : Commas::decimal;
  }
  return plain_.has_value();
}

Commas CommaFinder::found(bool point_elsewhere, bool commas_separate) const {
  if (plain_ || example_.empty()) return plain_.value_or(Commas::none);
  if (other_numbers_ || point_elsewhere) return Commas::thousands;
  return commas_separate ? Commas::unclear : Commas::decimal;
}

}  // namespace decid::recording
