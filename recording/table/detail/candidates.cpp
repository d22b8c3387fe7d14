// Candidates for the sway column: see candidates.hpp.
#include "recording/table/detail/candidates.hpp"

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "recording/table/cells.hpp"
#include "recording/table/columns.hpp"
#include "recording/table/detail/quaternion.hpp"

namespace decid::recording {

namespace {

bool is_counter_name(const std::string& name) {
  const std::vector<std::string> parts = words(name);
  if (std::ranges::count(parts, "stamp") > 0 || parts.back() == "seq" || is_nanoseconds_name(name))
    return true;  // of ROS
  return one_of(letters_of(name),
                {"frame",        "frames",        "frameno", "framenumber", "subframe",      "index",    "idx",
                 "item",         "row",           "nr",      "no",          "sample",        "samples",  "sampleno",
                 "samplenumber", "packetcounter", "counter", "count",       "mocapframe",    "unnamed0", "trial",
                 "subject",      "block",         "event",   "events",      "marker",        "trigger",  "comment",
                 "comments",     "annotation",    "status",  "valid",       "sampletimefine"});
}

/// Includes "q1", which is a joint's angle in some files.
bool may_be_quaternion(const std::string& name) {
  return is_quaternion_name(name) || one_of(letters_of(name), {"q0", "q1", "q2", "q3", "q4"});
}

/// Returns true for an unnamed column of 1, 2, 3 ...
bool is_unnamed_counter(const Table& table, int column) {
  const std::string& name = table.name(column);
  if (!table.has_header() || name != "column " + std::to_string(column + 1)) return false;
  try {
    const std::vector<double> values = table.numbers(column);
    for (std::size_t k = 1; k < values.size(); ++k)
      if (values[k] != values[k - 1] + 1.0) return false;
    return true;
  } catch (const Error&) {  // words, or nothing
    return true;
  }
}

/// Returns true for a text column: the cells of a few rows, spread over the column, are words, if they are not empty.
bool has_only_words(const Table& table, int column) {
  constexpr std::size_t some = 20;
  const std::size_t rows = table.rows(column);
  bool has_words = false;
  for (std::size_t i = 0; i < std::min(some, rows); ++i) {
    const std::string cell = table.label(column, i * rows / std::min(some, rows));
    if (is_value(cell)) return false;
    has_words = has_words || !is_missing(cell);
  }
  return has_words;
}

}  // namespace

std::vector<int> sway_candidates(const Table& table, int time) {
  std::vector<int> all, quaternions, signals, likely;
  for (int column = 0; column < table.columns(); ++column) {
    if (column == time) continue;
    all.push_back(column);
    const std::string& name = table.own_name(column);
    const bool is_named = table.has_header();
    if ((is_named && (is_counter_name(name) || is_time_name(name))) || is_unnamed_counter(table, column)) continue;
    if (has_only_words(table, column)) continue;
    if (is_named && may_be_quaternion(name)) {
      quaternions.push_back(column);
      continue;
    }
    signals.push_back(column);
    if (!is_named || other_quantity(name) == nullptr) likely.push_back(column);
  }
  if (!likely.empty()) return likely;
  if (!signals.empty()) return signals;
  return quaternions.empty() ? all : quaternions;
}

std::vector<int> length_candidates(const Table& table, int time) {
  std::vector<int> lengths;
  for (int column = 0; table.has_header() && column < table.columns(); ++column) {
    const std::string& name = table.own_name(column);
    const char* quantity = other_quantity(name);
    const bool is_pressure = quantity != nullptr && std::string_view(quantity) == centre_of_pressure;
    if (column != time && find_metres_per_unit(name) && !is_pressure && !is_time_name(name)) lengths.push_back(column);
  }
  return lengths;
}

std::vector<int> centre_of_mass_columns(const Table& table, const std::vector<int>& columns) {
  for (const std::string_view wanted : {"com_x", "com_ap", "com"}) {
    std::vector<int> found;
    for (const int column : columns) {
      std::string name = table.own_name(column);
      name = name_without_unit(std::string_view(name).substr(name.find_last_of(':') + 1));  // "Sub1:COM_X_mm"
      for (const std::string_view called : {"centre_of_mass", "center_of_mass", "centreofmass", "centerofmass", "ksp",
                                            "koerperschwerpunkt", "k\xC3\xB6rperschwerpunkt", "cog"})
        if (name == called || name.starts_with(std::string(called) + "_")) {
          name.replace(0, called.size(), "com");
          break;
        }
      if (name == wanted) found.push_back(column);
    }
    if (!found.empty()) return found;
  }
  return {};
}

}  // namespace decid::recording
