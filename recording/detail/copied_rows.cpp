// Rows that a program wrote twice: see copied_rows.hpp.
#include "recording/detail/copied_rows.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "base/error.hpp"

namespace decid::recording {

namespace {

/// Returns true if the cells of each row are those of the row before it. `rows`: ascending, not the first row.
bool are_copies(const Table& table, int column, const std::vector<std::size_t>& rows) {
  try {
    const std::vector<double> values = table.numbers(column, Missing::kept);
    return std::ranges::all_of(rows, [&](std::size_t row) {
      return values[row] == values[row - 1] || (std::isnan(values[row]) && std::isnan(values[row - 1]));
    });
  } catch (const Error&) {  // words
  }
  try {
    const RowLabels labels = table.labels(column);
    return std::ranges::all_of(rows, [&](std::size_t row) { return labels.of_row[row] == labels.of_row[row - 1]; });
  } catch (const Error&) {  // infinite numbers
    return false;
  }
}

}  // namespace

bool drop_copied_rows(Table& table, int time, Warnings& warnings) {
  std::vector<double> times;
  try {
    times = table.times(time);
  } catch (const Error&) {  // another check names the cell
    return false;
  }
  std::vector<std::size_t> copies;
  for (std::size_t row = 1; row < times.size(); ++row)
    if (times[row] == times[row - 1]) copies.push_back(row);
  if (copies.empty()) return false;
  for (int column = 0; column < table.columns(); ++column)
    if (table.rows(column) == times.size() && !are_copies(table, column, copies)) return false;
  std::vector<std::size_t> kept;
  for (std::size_t row = 0; row < times.size(); ++row)
    if (!std::ranges::binary_search(copies, row)) kept.push_back(row);
  if (kept.size() < 2) return false;
  const std::string place = table.locate(copies.front());
  table.keep_rows(time, kept);
  add_info(warnings, "copied_rows",
           std::to_string(copies.size()) +
               (copies.size() == 1 ? " row equals the row before it" : " rows equal the row before them") +
               ", time included (" + (copies.size() == 1 ? "" : "the first is ") + place + "): decid drops " +
               (copies.size() == 1 ? "it" : "them"));
  return true;
}

}  // namespace decid::recording
