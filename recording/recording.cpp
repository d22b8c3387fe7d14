// Recordings: the sway's column, unit and rate. recording/trial.cpp brings them to a protocol. The search rules are
// made for EUROBENCH files (time,COM_x), motion capture exports and decid's own files.
#include "recording/recording.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <tuple>

#include "base/error.hpp"
#include "base/setting.hpp"
#include "recording/detail/even_samples.hpp"
#include "recording/detail/find_clock.hpp"
#include "recording/detail/separate_rows.hpp"
#include "recording/detail/sway/read_sway.hpp"
#include "recording/detail/sway/sway_axis.hpp"
#include "recording/detail/sway/sway_size.hpp"
#include "recording/detail/sway/sway_source.hpp"
#include "recording/detail/tilt/read_tilt.hpp"
#include "recording/table/columns.hpp"
#include "recording/table/detail/trials.hpp"
#include "recording/table/table.hpp"

namespace decid::recording {

namespace {

/// Replaces numbers that stand for missing values by NaN: the given number, or the numbers that Visual3D, NDI and
/// spreadsheets write, if all others are far smaller.
void mark_missing(std::vector<double>& values, std::optional<double> given) {
  constexpr double far = 50.0;
  const auto is = [](double value, double mark) { return std::abs(value - mark) <= 1e-6 * std::abs(mark); };
  const auto is_mark = [&](double value) {
    if (given) return is(value, *given);
    const double size = std::abs(value);
    return size >= 9999.0 && (is(size, 9999.0) || is(size, 99999.0) || is(size, 999999.0) || is(size, 9.99e33) ||
                              is(size, 1e30) || is(value, -3.697314e28));
  };
  double min_mark = std::numeric_limits<double>::infinity(), largest = 0.0;
  for (const double value : values) {
    if (is_mark(value))
      min_mark = std::min(min_mark, std::abs(value));
    else if (std::isfinite(value))
      largest = std::max(largest, std::abs(value));
  }
  if (!given && !(far * largest < min_mark)) return;
  for (double& value : values)
    if (is_mark(value)) value = std::numeric_limits<double>::quiet_NaN();
}

/// Returns a column's numbers, of each step-th row; those that are missing are NaN.
std::vector<double> read_numbers(const Table& table, int column, std::optional<double> missing_value,
                                 std::size_t step = 1) {
  std::vector<double> raw =
      step == 1 ? table.numbers(column, Missing::kept) : table.numbers_of_each(column, step, Missing::kept);
  mark_missing(raw, missing_value);
  return raw;
}

/// Returns a column on the clock's even grid, with its gaps filled if allowed and added to `gaps`.
std::vector<double> read_column(const Table& table, int column, const Clock& clock, const RecordingOptions& options,
                                Recording& recording, std::vector<SampleRange>& gaps) {
  const std::vector<double> raw = read_numbers(table, column, options.missing_value);
  if (const std::string change = table.change_at(column); !change.empty())
    add_info(recording.warnings, "resampled", change);
  std::vector<double> values = place_evenly(raw, clock);
  // A gap has a place in the file if its first sample is a cell instead of a lost row.
  const auto place_of = [&](std::size_t sample) -> std::string {
    const auto at = static_cast<double>(sample);
    for (std::size_t row = 0; row < raw.size(); ++row) {
      if (!std::isnan(raw[row])) continue;
      const double place = clock.place.empty() ? static_cast<double>(row) : clock.place[row];
      if (std::abs(place - at) <= 1.0) return table.locate(row) + ", ";
      if (place > at) break;
    }
    return {};
  };
  const std::string filled =
      fill_gaps(values, clock.rate_hz, options.fill_gaps_s, table.name(column), recording.file, place_of, gaps);
  if (!filled.empty()) add_caution(recording.warnings, "gaps_filled", filled);
  return values;
}

void note_preamble(const Table& table, const RecordingOptions& options, Recording& recording) {
  if (table.preamble_lines() == 0 || options.skip_lines || !options.section.empty()) return;
  add_info(recording.warnings, "preamble",
           table.preamble_lines() == 1
               ? "the line above the table is ignored"
               : "the first " + std::to_string(table.preamble_lines()) + " lines above the table are ignored");
}

/// Returns the column of the sway's times, `time` or -1 if the user named that column as the sway. Throws Error for
/// times that are not the sway's.
int time_of_sway(const Table& table, int sway, int time, const RecordingOptions& options, const std::string& file) {
  const std::string& name = table.name(sway);
  if (sway == time) {
    if (!options.rate_hz && table.stated_rates().empty())
      throw Error(
          Code::column_unsuitable, file, "the named sway, '" + name + "', is the time column",
          "name the sway column with " + setting("column") + ", or give " + setting("rate") + " if this is the sway");
    return -1;
  }
  if (time >= 0 && table.rows(time) != table.rows(sway)) {
    throw Error(Code::size_mismatch, file,
                name + " has " + std::to_string(table.rows(sway)) + " values, its time " + table.name(time) + " " +
                    std::to_string(table.rows(time)),
                "name the sway with " + setting("column") + ", or give " + setting("rate") +
                    " and save the file without that time");
  }
  return time;
}

/// Reads the named tilt, or looks for one. Throws Error if settings of a tilt have none.
void read_any_tilt(const Table& table, int time, const SwaySource& source, const ReadColumn& read,
                   const RecordingOptions& options, Recording& recording) {
  if (!options.tilt_column.empty()) {
    read_tilt(table, named_column(table, options.tilt_column, recording.file, setting("tilt_column")),
              source.columns.front(), read, options, recording);
  } else if (options.find_tilt) {
    look_for_tilt(table, time, source.columns, read, options, recording);
  }
  if ((options.tilt_unit || options.invert_tilt) && recording.signals.find(platform_tilt) == nullptr)
    throw Error(Code::setting_missing, recording.file,
                "no tilt is read for " + setting("tilt_unit") + " or " + setting("invert") + " tilt",
                "name its column with " + setting("tilt_column"));
}

/// Reads a recording from a table that holds no other one. `axis`: the sway's column, if it is another axis of a centre
/// of mass; else -1. `known`: the table's separate rows, of the first reading.
Recording read_from(const std::shared_ptr<Table>& read, const std::string& file, const RecordingOptions& options,
                    int axis = -1, const std::shared_ptr<const SeparateRows>& known = nullptr) {
  Recording recording;
  recording.file = file;
  const Table& table = *read;
  recording.warnings = table.warnings();
  note_preamble(table, options, recording);
  int time = find_time(table);
  const SwaySource source = find_sway_source(table, time, options, recording, axis);
  const int sway = source.columns.front();
  if (read->choose(sway)) time = find_time(table);
  if (options.trial_column.empty() && !options.is_one_trial) refuse_several_trials(table, sway, time, recording.file);
  if (table.rows(sway) < 2)
    throw Error(Code::recording_too_short, recording.file, "has only one sample", "give a whole recording");
  time = time_of_sway(table, sway, time, options, recording.file);
  const auto numbers_of = [&](int column, std::size_t step) {
    return read_numbers(table, column, options.missing_value, step);
  };
  const auto separate =
      known ? known : std::make_shared<const SeparateRows>(*read, source.columns, time, numbers_of, file);
  if (options.rate_hz && separate->rows() > 0)
    throw Error(Code::times_uneven, recording.file,
                "rows without " + table.name(sway) + " hold values of other signals, so one rate does not fit all rows",
                "leave out " + setting("rate") + ": each signal is then read at its own times");
  if (!known && separate->rows() > 0)
    add_info(
        recording.warnings, "separate_rows",
        std::to_string(separate->rows()) + " rows have no " + table.name(sway) +
            " and values of other signals, as logs of several sensors do: decid reads each signal at its own times");
  const Clock clock = find_clock(*read, sway, time, options, recording);
  recording.rate_hz = clock.rate_hz;
  if (options.trial_column.empty() && !options.is_one_trial)
    std::tie(recording.change, recording.change_s) = describe_change(table, sway, time, clock.rate_hz);
  recording.first_time_s = clock.first_s;
  std::vector<SampleRange> gaps;
  const auto numbers = [&](int column) { return read_column(table, column, clock, options, recording, gaps); };
  Signal<double>& signal = recording.signals.add(read_sway(table, source, options, numbers, recording));
  recording.gaps = joined_ranges(std::move(gaps));
  const bool guessed =
      source.kind == SwaySource::Kind::angle && !options.unit && !unit_in(table.name(sway)) && !table.unit();
  const bool of_positions = source.kind == SwaySource::Kind::displacement || source.kind == SwaySource::Kind::markers;
  check_size(signal, guessed, options.mean_is_upright, of_positions, recording);
  // Other columns are read after this function returns.
  const auto with_missing = [read, clock, separate, missing_value = options.missing_value, samples = signal.rad.size()](
                                int column, std::size_t step) {
    if (step > 1 && (!clock.place.empty() || separate->rows() > 0)) return std::vector<double>();
    if (separate->has(column)) return separate->at(column, clock, samples);
    return place_evenly(read_numbers(*read, column, missing_value, step), clock);
  };
  check_hip(table, time, source, signal.rad, options, with_missing, recording);
  if (options.invert_sway)
    for (double& value : signal.rad) value = -value;
  read_any_tilt(table, time, source, with_missing, options, recording);
  if (options.column.empty() && options.ankle_column.empty() && source.columns.size() == 1) {
    for (const int column : axes_beside(table, sway, time)) {
      if (separate->has(column)) {
        recording.axis_problem += "; '" + table.name(column) + "' has rows of its own, and is read only if you name it";
        continue;
      }
      RecordingOptions of_axis = options;
      of_axis.column = table.name(column);
      try {
        recording.other_axes.push_back(read_from(read, file, of_axis, column, separate));
      } catch (const Error& error) {
        if (may_be_axis(table, column))
          recording.axis_problem += "; '" + table.name(column) + "' cannot be read: " + error.problem();
      }
    }
  }
  return recording;
}

}  // namespace

Recording read_recording(const std::filesystem::path& path, const RecordingOptions& options) {
  std::string file = path == standard_input ? "standard input" : path.string();
  const std::shared_ptr<Table> read = read_table(path, options.skip_lines, options.section);
  if (!options.trial_column.empty()) {
    keep_trial(*read, options.trial_column, options.trial, file);
    file += "#" + options.trial;
  }
  return read_from(read, file, options);
}

std::vector<std::string> list_trials(const std::filesystem::path& path, const RecordingOptions& options) {
  return trials_in(*read_table(path, options.skip_lines, options.section), options.trial_column, path.string());
}

Recording make_recording(std::span<const double> sway_rad, double rate_hz, bool mean_is_upright) {
  Recording recording;
  recording.rate_hz = rate_hz;
  if (!is_sample_rate(rate_hz))
    throw Error(Code::setting_out_of_range, "recording", "has a rate of " + six_digits(rate_hz) + " Hz",
                "give 1 to 100,000 Hz");
  if (sway_rad.size() < 2)
    throw Error(Code::recording_too_short, "recording", sway_rad.empty() ? "has no samples" : "has only one sample",
                "give a whole recording");
  for (std::size_t k = 0; k < sway_rad.size(); ++k)
    if (!std::isfinite(sway_rad[k]))
      throw Error(Code::value_invalid, "recording",
                  "sample " + std::to_string(k + 1) + " (counted from 1) is not finite", "interpolate missing samples");
  const Signal<double>& sway = recording.signals.add({com_sway, "sway", {sway_rad.begin(), sway_rad.end()}});
  check_size(sway, false, mean_is_upright, false, recording);
  return recording;
}

}  // namespace decid::recording
