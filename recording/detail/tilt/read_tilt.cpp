// The platform's tilt in a table: see read_tilt.hpp.
#include "recording/detail/tilt/read_tilt.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/error.hpp"
#include "base/math/statistics.hpp"
#include "base/number.hpp"
#include "base/setting.hpp"
#include "recording/detail/even_samples.hpp"
#include "recording/detail/sway/sway_name.hpp"
#include "recording/table/columns.hpp"
#include "recording/table/detail/candidates.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::recording {
namespace {

constexpr double far_rad = 90.0 * sim::rad_per_deg;
constexpr double longest_slow_s = 0.2;         // between values of a slow sensor: 5 Hz, the slowest recording
constexpr double screen_hz = 10.0;             // of the first comparison of other columns
constexpr std::size_t max_other_columns = 64;  // markers and sensors of a laboratory that names no tilt

/// Returns the number of values missing in runs of more than `longest` samples.
std::size_t missing_in_runs(const std::vector<double>& values, double longest) {
  std::size_t missing = 0, run = 0;
  for (std::size_t k = 0; k <= values.size(); ++k) {
    if (k < values.size() && std::isnan(values[k])) {
      ++run;
      continue;
    }
    if (static_cast<double>(run) > longest) missing += run;
    run = 0;
  }
  return missing;
}

/// Fills missing values and adds them to `gaps`. Returns a text about them, empty without any. If more than half of the
/// values are missing, short runs are those of a slower sensor: they are not added. Throws Error if more than half of
/// the values are missing in longer runs.
std::string bridge(std::vector<double>& values, const std::string& name, const Recording& recording,
                   std::vector<SampleRange>& gaps) {
  const double slow_samples = longest_slow_s * recording.rate_hz * (1.0 + 1e-9);
  const std::size_t all = missing_in_runs(values, 0.0);
  if (all == 0) return {};
  const bool is_slow = 2 * all > values.size();
  const std::size_t missing = is_slow ? missing_in_runs(values, slow_samples) : all;
  if (2 * missing > values.size())
    throw Error(Code::value_missing, recording.file,
                name + " lacks " + std::to_string(missing) + " of its " + std::to_string(values.size()) +
                    " samples, too many to compare the tilt with a protocol",
                "give a tilt that was measured throughout, or " + setting("tilt_column") + " none");
  const auto no_place = [](std::size_t) { return std::string(); };
  std::string text = fill_gaps(values, recording.rate_hz, std::numeric_limits<double>::infinity(), name, recording.file,
                               no_place, gaps);
  if (is_slow)
    std::erase_if(gaps, [&](const SampleRange& gap) { return static_cast<double>(gap.size()) <= slow_samples; });
  return text;
}

/// Throws Error for a few numbers far from the others. `factor`: radians per number of the file.
void refuse_codes(const Signal<double>& tilt, double factor, const Recording& recording) {
  constexpr std::size_t few_divisor = 10;
  const auto [low, high] = std::ranges::minmax(tilt.rad);
  if (high - low <= far_rad) return;
  const double middle = median(tilt.rad);
  const auto is_far = [&](double value) { return std::abs(value - middle) > far_rad; };
  const auto first = std::ranges::find_if(tilt.rad, is_far);
  const auto count = static_cast<std::size_t>(std::ranges::count_if(tilt.rad, is_far));
  if (count == 0 || few_divisor * count > tilt.rad.size()) return;
  const std::string number = six_digits(*first / factor);
  throw Error(Code::value_invalid, recording.file,
              "the tilt " + tilt.column + " is " + number + " at sample " +
                  std::to_string(first - tilt.rad.begin() + 1) + ", more than 90 degrees from its median, in " +
                  std::to_string(count) + (count == 1 ? " sample" : " samples"),
              "give " + setting("missing") + " " + number + " if that stands for a missing value");
}

/// Returns whether fewer than half of a column's cells are numbers.
bool holds_words(const Table& table, int column) {
  RowLabels labels;
  try {
    labels = table.labels(column);
  } catch (const Error&) {  // a file of numbers only
    return false;
  }
  std::vector<bool> is_number;
  for (const std::string& value : labels.values) is_number.push_back(number_from<double>(value).has_value());
  std::size_t numbers = 0;
  for (const std::uint32_t label : labels.of_row) numbers += is_number[label] ? 1 : 0;
  return 2 * numbers < labels.of_row.size();
}

std::string cannot_check(const Error& error) {
  return "decid cannot check the platform's start, size and sign by its tilt: " + error.problem() + "; " +
         error.remedy();
}

void read_other_columns(const Table& table, int time, const std::vector<int>& sways, const ReadColumn& read,
                        Recording& recording) {
  for (const int column : sway_candidates(table, time)) {
    const std::string& name = table.name(column);
    if (std::ranges::find(sways, column) != sways.end() || table.rows(column) != table.rows(sways.front()) ||
        other_quantity(name) != nullptr || is_ankle_name(name))
      continue;
    const double factor = rad_in(unit_in(name).value_or(table.unit().value_or(Unit::degree)));
    OtherColumn other{name, unit_in(name) || table.unit(), {}};
    other.rad = [read, column, factor, name, rate_hz = recording.rate_hz, file = recording.file] {
      std::vector<double> values = read(column, 1);
      Recording of_column;
      of_column.file = file;
      of_column.rate_hz = rate_hz;
      std::vector<SampleRange> gaps;
      bridge(values, name, of_column, gaps);
      for (double& value : values) value *= factor;
      return values;
    };
    other.coarse_step = static_cast<std::size_t>(std::max(1L, std::lround(recording.rate_hz / screen_hz)));
    try {
      other.coarse_rad = read(column, other.coarse_step);
    } catch (const Error&) {  // words
      continue;
    }
    const auto is_missing = [](double value) { return std::isnan(value); };
    if (std::ranges::any_of(other.coarse_rad, is_missing)) other.coarse_rad.clear();
    for (double& value : other.coarse_rad) value *= factor;
    recording.other_columns.push_back(std::move(other));
    if (recording.other_columns.size() == max_other_columns) return;
  }
}

/// Returns the column called tilt or similar, -1 without one or if several of one name differ: then the recording has
/// a tilt_problem. If they are equal, returns the first, with an info.
int tilt_by_name(const Table& table, const ReadColumn& read, Recording& recording) {
  try {
    return find_tilt_column(table, -1, recording.file, setting("tilt_column"));
  } catch (const Error& error) {
    if (error.code() != Code::column_ambiguous) throw;
    recording.tilt_problem = cannot_check(error);
  }
  std::vector<int> columns = tilt_columns(table, -1);
  const auto count_of = [&](int column) {
    return std::ranges::count_if(columns, [&](int i) { return table.own_name(i) == table.own_name(column); });
  };
  const auto first = std::ranges::find_if(columns, [&](int column) { return count_of(column) > 1; });
  if (first == columns.end()) return -1;
  const int result = *first;
  const std::string& name = table.own_name(result);
  std::erase_if(columns, [&](int column) { return table.own_name(column) != name; });
  const auto is_same = [](double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); };
  const std::vector<double> values = read(result, 1);
  for (const int column : columns)
    if (!std::ranges::equal(read(column, 1), values, is_same)) return -1;
  recording.tilt_problem.clear();
  add_info(recording.warnings, "tilt_found",
           std::to_string(columns.size()) + " columns are called '" + name + "' and are equal; decid uses the first");
  return result;
}

/// Returns the unit of the tilt: the given one, else its name's, else the given unit of the sway, else the file's, else
/// degrees.
Unit tilt_unit(const Table& table, int column, const RecordingOptions& options, Recording& recording) {
  const std::string& name = table.name(column);
  const std::string own_setting = setting("tilt_unit");
  if (options.tilt_unit || !options.unit || find_unit(name, {}, recording.file, own_setting))
    return angle_unit(table, column, options.tilt_unit, own_setting, recording);
  add_info(recording.warnings, "unit_assumed",
           "the name of " + name + " has no unit: decid assumes that of " + setting("unit") + "; " + own_setting +
               " gives another");
  return *options.unit;
}

}  // namespace

void read_tilt(const Table& table, int column, int sway, const ReadColumn& read, const RecordingOptions& options,
               Recording& recording) {
  const std::string& name = table.name(column);
  if (column == sway)
    throw Error(Code::column_unsuitable, recording.file, name + " is already the sway",
                "name the tilt with " + setting("tilt_column"));
  if (table.rows(column) != table.rows(sway)) {
    throw Error(Code::size_mismatch, recording.file,
                "the tilt " + name + " has " + std::to_string(table.rows(column)) + " values, the sway " +
                    std::to_string(table.rows(sway)),
                "name signals that were sampled together");
  }
  const Unit unit = tilt_unit(table, column, options, recording);
  Signal<double> tilt{platform_tilt, name, read(column, 1)};
  if (const std::string change = table.change_at(column); !change.empty())
    add_info(recording.warnings, "resampled", change);
  std::vector<SampleRange> gaps;
  if (const std::string bridged = bridge(tilt.rad, name, recording, gaps); !bridged.empty())
    add_info(recording.warnings, "gaps_filled",
             bridged + "; decid compares the tilt with the protocol where it was measured");
  const double factor = rad_in(unit) * (options.invert_tilt ? -1.0 : 1.0);
  for (double& value : tilt.rad) value *= factor;
  refuse_codes(tilt, factor, recording);
  recording.tilt_gaps = joined_ranges(std::move(gaps));
  recording.signals.add(std::move(tilt));
}

void look_for_tilt(const Table& table, int time, const std::vector<int>& sways, const ReadColumn& read,
                   const RecordingOptions& options, Recording& recording) {
  const std::size_t warnings = recording.warnings.size();
  int column = -1;
  try {
    column = tilt_by_name(table, read, recording);
    const bool is_sway = std::ranges::find(sways, column) != sways.end();
    if (column < 0 || is_sway) {
      read_other_columns(table, time, sways, read, recording);
      if (recording.other_columns.empty() && !recording.tilt_problem.empty())
        add_caution(recording.warnings, "tilt_not_used", std::exchange(recording.tilt_problem, {}));
      return;
    }
    read_tilt(table, column, sways.front(), read, options, recording);
    recording.tilt_was_found = true;
    for (const int other : tilt_columns(table, column))
      if (std::ranges::find(sways, other) == sways.end() && table.own_name(other) != table.own_name(column))
        add_info(recording.warnings, "tilt_found",
                 "the column '" + table.name(other) + "' is the platform's tilt by its name too; decid uses '" +
                     table.name(column) + "', unless you name another as " + setting("tilt_column"));
  } catch (const Error& error) {
    recording.warnings.erase(recording.warnings.begin() + static_cast<std::ptrdiff_t>(warnings),
                             recording.warnings.end());
    const bool is_other = error.code() == Code::column_unsuitable ||
                          (error.code() == Code::value_invalid && column >= 0 && holds_words(table, column));
    if (is_other)
      add_info(recording.warnings, "tilt_not_used", "decid ignores a column that may be the tilt: " + error.problem());
    else
      add_caution(recording.warnings, "tilt_not_used", cannot_check(error));
  }
}

}  // namespace decid::recording
