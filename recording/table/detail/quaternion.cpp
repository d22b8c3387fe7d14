// Columns of quaternions: see quaternion.hpp.
#include "recording/table/detail/quaternion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "base/error.hpp"
#include "recording/table/columns.hpp"

namespace decid::recording {

namespace {

constexpr int all_parts = 4;

/// Returns true if the squares of four columns add up to 1, far closer than by three small columns beside a constant 1.
bool are_unit(std::span<const std::vector<double>> columns) {
  constexpr double max_norm_error = 1e-3, max_error_over_small = 0.2;
  constexpr std::size_t min_rows = 3;
  double off = 0.0, small = 0.0;
  for (std::size_t k = 0; k < columns.front().size(); ++k) {
    double sum = 0.0, largest = 0.0;
    for (const std::vector<double>& column : columns) {
      const double square = column[k] * column[k];
      sum += square;
      largest = std::max(largest, square);
    }
    if (!(std::abs(sum - 1.0) <= max_norm_error)) return false;
    off += std::abs(sum - 1.0);
    small += sum - largest;
  }
  return columns.front().size() >= min_rows && off < max_error_over_small * small;
}

/// Returns true if the columns from `first` on are four neighbours that form a quaternion.
bool forms_quaternion(const Table& table, int first) {
  if (first < 0 || first + all_parts > table.columns()) return false;
  constexpr std::size_t some_rows = 32;
  const std::size_t rows = table.rows(first);
  for (int i = 1; i < all_parts; ++i)
    if (table.rows(first + i) != rows) return false;
  // A few rows exclude most columns, faster than all rows.
  for (const std::size_t step : {rows / some_rows + 1, std::size_t{1}}) {
    std::array<std::vector<double>, all_parts> values;
    try {
      for (int i = 0; i < all_parts; ++i)
        values[static_cast<std::size_t>(i)] = table.numbers_of_each(first + i, step, Missing::refused);
    } catch (const Error&) {  // words, or missing values
      return false;
    }
    if (!are_unit(values)) return false;
  }
  return true;
}

}  // namespace

bool is_quaternion_name(const std::string& name) {
  if (unit_in(name)) return false;
  const std::vector<std::string> all = words_in(name);
  const auto has = [&](std::initializer_list<std::string_view> list) {
    return std::ranges::any_of(all, [&](const std::string& word) { return one_of(word, list); });
  };
  if (has({"pitch", "roll", "yaw", "angle", "euler", "winkel", "tilt", "sway", "lean"})) return false;
  return has({"qw", "qx", "qy", "qz"}) ||
         std::ranges::any_of(all, [](const std::string& word) { return word.starts_with("quat"); });
}

std::vector<int> quaternion_columns(const Table& table, const std::vector<int>& among) {
  std::vector<int> found;
  const auto add = [&](int column) {
    if (std::ranges::find(found, column) == found.end()) found.push_back(column);
  };
  for (const int column : among)
    if (table.has_header() && is_quaternion_name(table.own_name(column))) add(column);
  const auto is_among = [&](int column) { return std::ranges::find(among, column) != among.end(); };
  for (const int column : among) {
    const bool are_among = is_among(column + 1) && is_among(column + 2) && is_among(column + 3);
    if (are_among && forms_quaternion(table, column))
      for (int i = 0; i < all_parts; ++i) add(column + i);
  }
  std::ranges::sort(found);
  return found;
}

void refuse_quaternion(const Table& table, int column, const std::string& where) {
  const bool by_name = table.has_header() && is_quaternion_name(table.own_name(column));
  bool by_values = false;
  for (int first = column - all_parts + 1; !by_name && !by_values && first <= column; ++first)
    by_values = forms_quaternion(table, first);
  if (!by_name && !by_values) return;
  throw Error(
      Code::column_unsuitable, where,
      table.name(column) + " is a part of a quaternion by " + (by_name ? "its name" : "its values") + ", not an angle",
      "compute the pitch angle from the quaternion, in degrees");
}

}  // namespace decid::recording
