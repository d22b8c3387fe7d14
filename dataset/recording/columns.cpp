// Columns of a table: see columns.hpp. The rules for finding them are ours, made for EUROBENCH files (time,COM_x),
// exports of motion capture and decid's own.
#include "dataset/recording/columns.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>

#include "base/error.hpp"

namespace decid::dataset {

namespace {

/// How much a step of a column without a name may differ from the mean step, for it to be a time.
constexpr double step_tolerance = 0.01;

bool is_time(std::string_view name) {
  return one_of(words(name).front(), {"time", "t", "times", "timestamp", "timestamps", "zeit", "seconds", "sec", "ms"});
}

}  // namespace

std::string six_digits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::vector<std::string> words(std::string_view name) {
  std::vector<std::string> parts(1);
  for (const char c : name) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) || byte >= 0x80) {
      parts.back() += static_cast<char>(std::tolower(byte));
    } else if (!parts.back().empty()) {
      parts.emplace_back();
    }
  }
  if (parts.back().empty() && parts.size() > 1) parts.pop_back();
  return parts;
}

bool one_of(std::string_view word, std::initializer_list<std::string_view> list) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

std::optional<Unit> unit_in(std::string_view name) {
  const std::string unit = words(name).back();
  if (one_of(unit, {"deg", "degree", "degrees", "\xC2\xB0"})) return Unit::degree;
  if (one_of(unit, {"rad", "radian", "radians"})) return Unit::radian;
  return {};
}

std::string name_without_unit(std::string_view name) {
  std::vector<std::string> parts = words(name);
  if (parts.size() > 1 && unit_in(name)) parts.pop_back();
  std::string joined;
  for (const std::string& part : parts) joined += (joined.empty() ? "" : "_") + part;
  return joined;
}

std::string list_of(const Table& table, int without) {
  std::string list;
  for (int i = 0; i < table.columns(); ++i) {
    if (i == without) continue;
    if (list.size() > 200) return list + ", ...";
    list += (list.empty() ? "'" : ", '") + table.names()[static_cast<std::size_t>(i)] + "'";
  }
  return list;
}

int named_column(const Table& table, const std::string& column, const std::string& where, const std::string& setting) {
  const auto lower = [](std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
  };
  std::vector<int> exact, alike;
  for (int i = 0; i < table.columns(); ++i) {
    const std::string& name = table.names()[static_cast<std::size_t>(i)];
    if (name == column) exact.push_back(i);
    if (lower(name) == lower(column)) alike.push_back(i);
  }
  const std::vector<int>& found = exact.empty() ? alike : exact;
  if (found.size() == 1) return found.front();
  if (found.size() > 1) {
    throw Error(where, std::to_string(found.size()) + " columns are called '" + column + "'",
                "give the column's number, from 1, as " + setting);
  }
  int number = 0;
  const auto [end, error] = std::from_chars(column.data(), column.data() + column.size(), number);
  if (error == std::errc() && end == column.data() + column.size() && number >= 1 && number <= table.columns()) {
    return number - 1;
  }
  throw Error(where, "has no column '" + column + "'; its columns are " + list_of(table, -1),
              "give one of them, or its number from 1, as " + setting);
}

int find_time(const Table& table) {
  if (table.has_header()) {
    const auto& names = table.names();
    const auto found = std::find_if(names.begin(), names.end(), is_time);
    return found == names.end() ? -1 : static_cast<int>(found - names.begin());
  }
  if (table.rate_hz() || table.columns() < 2 || table.rows(0) < 3) return -1;
  const std::vector<double> first = table.numbers(0);
  const double step = (first.back() - first.front()) / static_cast<double>(first.size() - 1);
  for (std::size_t i = 1; i < first.size(); ++i) {
    const double found = first[i] - first[i - 1];
    if (found <= 0.0 || std::abs(found - step) > 2.0 * step_tolerance * step) return -1;
  }
  return 0;
}

double time_unit_s(std::string_view name) {
  const std::string unit = words(name).back();
  if (one_of(unit, {"ms", "msec", "milliseconds"})) return 1e-3;
  if (one_of(unit, {"us", "usec", "\xC2\xB5s", "microseconds"})) return 1e-6;
  return 1.0;
}

}  // namespace decid::dataset
