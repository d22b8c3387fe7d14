// Signals in rows of their own: see separate_rows.hpp.
#include "recording/detail/separate_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "base/math/statistics.hpp"

namespace decid::recording {
namespace {

constexpr double min_other = 0.05;  // of all rows
constexpr double nearly = 0.9;      // of the rows; signals may share a time now and then
constexpr double gap_s = 0.1, gap_steps = 2.5;
constexpr double max_shared = 0.1;  // of a signal's times; more are rounded, and tell nothing about its place
constexpr std::size_t min_values = 20;
// Most tables have the sway in all rows, which every 61st row shows: no few signals take turns by a multiple of 61.
constexpr std::size_t glance_step = 61, min_glance_rows = 6000;

/// Returns true if the values change, unlike those of a flag of missing samples, and have times of their own.
bool is_signal(const std::vector<double>& time, const std::vector<double>& value) {
  std::size_t shared = 0;
  for (std::size_t i = 1; i < time.size(); ++i) shared += time[i] == time[i - 1] ? 1 : 0;
  return std::ranges::any_of(value, [&](double other) { return other != value.front(); }) &&
         static_cast<double>(shared) <= max_shared * static_cast<double>(time.size());
}

/// Throws Error if the sway has several columns, each with values in rows of its own: few rows then have them all.
void refuse_rows_of_each(const Table& table, const std::vector<int>& sway, const SeparateRows::Read& read,
                         std::size_t common, const std::string& file) {
  if (sway.size() < 2) return;
  std::string names;
  for (const int column : sway) {
    const auto values =
        static_cast<double>(std::ranges::count_if(read(column, 1), [](double value) { return std::isfinite(value); }));
    if (values < min_values || static_cast<double>(common) > (1.0 - nearly) * values) return;
    names += (names.empty() ? "" : ", ") + table.name(column);
  }
  throw Error(Code::times_uneven, file, "values of " + names + " are in different rows, as in a log of several sensors",
              "save all of them at the same times, one row per time");
}

}  // namespace

SeparateRows::SeparateRows(Table& table, const std::vector<int>& sway, int time, const Read& read,
                           const std::string& file) {
  if (time < 0) return;
  const std::size_t rows = table.rows(time);
  if (std::ranges::any_of(sway, [&](int column) { return table.rows(column) != rows; })) return;
  const auto lacks = [&](int column) {
    return std::ranges::any_of(read(column, rows < min_glance_rows ? 1 : glance_step),
                               [](double value) { return !std::isfinite(value); });
  };
  if (std::ranges::none_of(sway, lacks)) return;
  std::vector<bool> has_sway(rows, true);
  for (const int column : sway) {
    const std::vector<double> values = read(column, 1);
    for (std::size_t row = 0; row < rows; ++row)
      if (!std::isfinite(values[row])) has_sway[row] = false;
  }
  std::vector<std::size_t> kept;
  for (std::size_t row = 0; row < rows; ++row)
    if (has_sway[row]) kept.push_back(row);
  refuse_rows_of_each(table, sway, read, kept.size(), file);
  const auto others = static_cast<double>(rows - kept.size());
  if (others < min_other * static_cast<double>(rows) || kept.size() < min_values) return;

  std::vector<double> times;
  try {
    times = table.times(time);
  } catch (const Error&) {  // another check names the cell
    return;
  }
  if (!std::ranges::is_sorted(times)) return;
  std::vector<bool> has_other(rows, false);
  for (int column = 0; column < table.columns(); ++column) {
    if (column == time || std::ranges::count(sway, column) > 0 || table.rows(column) != rows) continue;
    std::vector<double> values;
    try {
      values = read(column, 1);
    } catch (const Error&) {  // words
      continue;
    }
    const auto shared =
        static_cast<double>(std::ranges::count_if(kept, [&](std::size_t row) { return std::isfinite(values[row]); }));
    if (shared > (1.0 - nearly) * static_cast<double>(kept.size())) continue;
    Signal signal;
    std::vector<std::size_t> own;
    for (std::size_t row = 0; row < rows; ++row) {
      if (!std::isfinite(values[row])) continue;
      own.push_back(row);
      signal.time.push_back(times[row]);
      signal.value.push_back(values[row]);
    }
    if (own.size() < min_values || !is_signal(signal.time, signal.value)) continue;
    for (const std::size_t row : own) has_other[row] = true;
    signals_.emplace(column, std::move(signal));
  }
  double explained = 0.0;
  for (std::size_t row = 0; row < rows; ++row) explained += !has_sway[row] && has_other[row] ? 1.0 : 0.0;
  if (explained >= nearly * others) table.keep_rows(time, kept);
  if (table.rows(time) == rows) {
    signals_.clear();
    return;
  }
  rows_ = rows - kept.size();
}

std::vector<double> SeparateRows::at(int column, const Clock& clock, std::size_t samples) const {
  const auto& [time, value] = signals_.at(column);
  std::vector<double> steps(time.size() - 1);
  for (std::size_t i = 0; i < steps.size(); ++i) steps[i] = time[i + 1] - time[i];
  const double longest = std::max(gap_s / clock.unit_s, gap_steps * median(steps));
  const double first = clock.first_s / clock.unit_s, step = 1.0 / (clock.rate_hz * clock.unit_s);
  std::vector<double> result(samples, std::numeric_limits<double>::quiet_NaN());
  std::size_t i = 0;  // the values around a sample are i and i + 1
  for (std::size_t k = 0; k < samples; ++k) {
    const double at = first + static_cast<double>(k) * step;
    while (i + 2 < time.size() && time[i + 1] < at) ++i;
    if (at < time[i] || at > time[i + 1]) {
      // Signals do not begin and end in the same row.
      const double beyond = at < time[i] ? time[i] - at : at - time[i + 1];
      if (beyond <= longest) result[k] = at < time[i] ? value[i] : value[i + 1];
    } else if (const double between = time[i + 1] - time[i]; between == 0.0) {
      result[k] = value[i];
    } else if (between <= longest) {
      result[k] = value[i] + (at - time[i]) / between * (value[i + 1] - value[i]);
    }
  }
  return result;
}

}  // namespace decid::recording
