// Recordings: the sway's column, unit and rate. recording/trial.cpp brings them to a protocol. The search rules are
// made for EUROBENCH files (time,COM_x), motion capture exports and decid's own files.
#include "recording/recording.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <tuple>

#include "base/error.hpp"
#include "base/math/statistics.hpp"
#include "base/setting.hpp"
#include "recording/detail/clock.hpp"
#include "recording/detail/recording_name.hpp"
#include "recording/detail/separate_rows.hpp"
#include "recording/detail/sway/read_sway.hpp"
#include "recording/detail/sway/sway_axis.hpp"
#include "recording/detail/sway/sway_source.hpp"
#include "recording/detail/tilt/read_tilt.hpp"
#include "recording/table/columns.hpp"
#include "recording/table/detail/trials.hpp"
#include "recording/table/table.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::recording {

namespace {

/// A sway below min_plausible_deg is more likely in radians: quiet stance alone sways more.
constexpr double max_plausible_deg = 20.0, min_plausible_deg = 0.1, max_deg = 90.0;
/// Bounds of a sway whose unit is assumed: beyond them it is more likely in cm, mm or volts.
constexpr double max_assumed_deg = 20.0, max_assumed_sd_deg = 5.0;

/// Returns the advice for a time column that would mean this rate in seconds.
std::string time_hint(const std::string& name, double rate_hz) {
  for (const auto& [unit, end, per_s] : {std::tuple{"milliseconds", "_ms", 1e3},
                                         {"microseconds", "_us", 1e6},
                                         {"nanoseconds", "_ns", 1e9},
                                         {"days", "_days", 1.0 / 86400.0}}) {
    const double then_hz = rate_hz * per_s;
    if (then_hz >= 20.0 && then_hz <= 2000.0)
      return std::string("if it is in ") + unit + " (" + six_digits(std::round(then_hz * 1e3) / 1e3) +
             " Hz), name it " + name + end + ", or give " + setting("rate");
  }
  for (const auto& [unit, of_s] : {std::pair{"minutes", 60.0}, {"hours", 3600.0}}) {
    const double then_hz = rate_hz / of_s;
    if (then_hz >= 20.0 && then_hz <= 2000.0 && std::abs(then_hz - std::round(then_hz)) < 1e-3)
      return std::string("if it is in ") + unit + ", give " + setting("rate") + " " +
             six_digits(std::round(then_hz * 1e3) / 1e3);
  }
  if (is_sample_rate(rate_hz)) return "give " + setting("rate") + " if these times are wrong";
  return rate_hz < lowest_rate_hz ? "if it is in milliseconds, name it time_ms, or give " + setting("rate")
                                  : "if it is in seconds, name it time_s, or give " + setting("rate");
}

/// Warns if a given rate differs from the file's own rate.
void compare_rates(const Table& table, double given_hz, Recording& recording) {
  for (const StatedRate& stated : table.stated_rates())
    if (std::abs(stated.hz - given_hz) > rate_tolerance * given_hz) {
      add_caution(recording.warnings, "rate_differs",
                  "'" + stated.phrase + "' in the file is " + six_digits(stated.hz) +
                      " Hz; decid uses the given rate, " + six_digits(given_hz) + " Hz");
      return;
    }
}

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

/// Drops rows that equal the row before them in every column as long as the time. Returns an info that counts them;
/// nothing if there are none. Does nothing if a row has the time of the row before it, and other values: then its
/// time is wrong.
Warnings drop_copied_rows(Table& table, int time) {
  std::vector<double> times;
  try {
    times = table.times(time);
  } catch (const Error&) {  // another check names the cell
    return {};
  }
  std::vector<std::size_t> copies;
  for (std::size_t row = 1; row < times.size(); ++row)
    if (times[row] == times[row - 1]) copies.push_back(row);
  if (copies.empty()) return {};
  for (int column = 0; column < table.columns(); ++column)
    if (table.rows(column) == times.size() && !are_copies(table, column, copies)) return {};
  std::vector<std::size_t> kept;
  for (std::size_t row = 0; row < times.size(); ++row)
    if (!std::ranges::binary_search(copies, row)) kept.push_back(row);
  if (kept.size() < 2) return {};
  const std::string place = table.locate(copies.front());
  table.keep_rows(time, kept);
  return {{Severity::info, "copied_rows",
           std::to_string(copies.size()) +
               (copies.size() == 1 ? " row equals the row before it" : " rows equal the row before them") +
               ", time included (" + (copies.size() == 1 ? "" : "the first is ") + place + "): decid drops " +
               (copies.size() == 1 ? "it" : "them")}};
}

/// Returns the clock of a time column, without rows that are copies of the row before them.
Clock read_times(Table& table, int time, Recording& recording) {
  const auto read = [&] { return read_clock(table, time, recording.file, setting("rate")); };
  const auto drop_copies = [&] {
    Warnings dropped = drop_copied_rows(table, time);
    const bool has_dropped = !dropped.empty();
    append(recording.warnings, std::move(dropped));
    return has_dropped;
  };
  Clock clock;
  try {
    clock = read();
  } catch (const Error&) {
    if (!drop_copies()) throw;
    return read();
  }
  return clock.has_shared_times && drop_copies() ? read() : clock;
}

Clock find_clock(Table& table, int sway, int time, const RecordingOptions& options, Recording& recording) {
  if (options.rate_hz && !is_sample_rate(*options.rate_hz)) {
    throw Error(Code::setting_out_of_range, recording.file,
                "the rate " + six_digits(*options.rate_hz) + " Hz is not from 1 to 100,000 Hz",
                "give the samples per second as " + setting("rate"));
  }
  Clock given;
  given.rate_hz = options.rate_hz.value_or(0.0);
  if (time < 0) {
    if (options.rate_hz) {
      if (table.is_even()) compare_rates(table, *options.rate_hz, recording);
      return given;
    }
    const std::optional<StatedRate> stated = stated_rate(table, recording.file, setting("rate"));
    if (!stated)
      throw Error(Code::rate_unknown, recording.file, "has no time column",
                  "give the sample rate in Hz as " + setting("rate"));
    if (!table.is_even())
      add_info(recording.warnings, "rate_stated",
               "the rate is " + six_digits(stated->hz) + " Hz by '" + stated->phrase + "' in the file");
    given.rate_hz = stated->hz;
    return given;
  }
  const std::string name = "'" + table.name(time) + "'";
  Clock clock;
  try {
    clock = read_times(table, time, recording);
  } catch (const Error& error) {
    const std::vector<std::size_t> starts = restarts(table, time);
    const std::string exchanged = exchanged_with_time(table, starts.empty() ? -1 : sway, time);
    if (!exchanged.empty() && !options.rate_hz)
      throw Error(error.code(), error.where(), error.problem() + ", and '" + exchanged + "' contains times",
                  "correct the header if the two names are swapped");
    if (!starts.empty())  // A given rate would join the recordings.
      throw Error(error.code(), error.where(),
                  table.locate(starts.front()) + ": " + name + " starts again: the file holds several recordings",
                  remedy_for_several(table, sway, time, starts, options.trial_column));
    if (!options.rate_hz) throw;
    add_info(recording.warnings, "time_not_used", "decid ignores the time column: " + error.problem());
    return given;
  }
  if (options.rate_hz) {
    if (std::abs(clock.rate_hz - *options.rate_hz) > rate_tolerance * clock.rate_hz) {
      add_caution(recording.warnings, "rate_differs",
                  "the column " + name + " gives " + six_digits(clock.rate_hz) + " Hz; decid uses the given rate, " +
                      six_digits(*options.rate_hz) + " Hz");
    }
    return given;
  }
  recording.rate_advice = time_hint(table.name(time), clock.rate_hz);
  if (!is_sample_rate(clock.rate_hz)) {
    throw Error(Code::setting_out_of_range, recording.file,
                "the column " + name + " gives " + six_digits(clock.rate_hz) + " Hz, not from 1 to 100,000",
                recording.rate_advice);
  }
  if (!clock.warning.empty())
    add_warning(recording.warnings, clock.is_caution ? Severity::caution : Severity::info, "uneven_times",
                clock.warning);
  return clock;
}

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

/// Warns of a sway that is too large for the degrees in which it was read without a unit.
void check_assumed_unit(const Signal<double>& sway, double peak_to_peak_deg, const std::string& remedy,
                        Recording& recording) {
  const double sd_deg = stddev(sway.rad) / sim::rad_per_deg;
  if (peak_to_peak_deg <= max_assumed_deg && sd_deg <= max_assumed_sd_deg) return;
  recording.is_large = true;
  add_caution(recording.warnings, "large_sway",
              "the name of " + sway.column + " has no unit, and in degrees its standard deviation is " +
                  three_digits(sd_deg) + " and its peak to peak " + three_digits(peak_to_peak_deg) +
                  ", more than a standing body sways; " + remedy);
}

/// Throws Error if the sway is too large for a standing body, and warns of suspicious sizes. `guessed`: its unit was
/// guessed. `mean_is_upright`: sizes count from the mean instead of 0. `of_positions`: the sway was computed from them.
void check_size(const Signal<double>& sway, bool guessed, bool mean_is_upright, bool of_positions,
                Recording& recording) {
  const std::string other =
      either(recording, "give radians",
             "if the unit is wrong, give " + setting("unit") +
                 (of_positions ? "; check the heights of the positions, and that their axis is the tilt's direction"
                               : "; if these are positions, give " + setting("com_height")));
  const auto [low, high] = std::minmax_element(sway.rad.begin(), sway.rad.end());
  const double middle = mean(sway.rad), upright = mean_is_upright ? middle : 0.0;
  const double peak_deg = std::max(upright - *low, *high - upright) / sim::rad_per_deg;
  const double peak_to_peak_deg = (*high - *low) / sim::rad_per_deg;
  if (*low == *high) {
    throw Error(Code::value_invalid, where(recording),
                sway.column + " is constant, " + three_digits(*high / sim::rad_per_deg + 0.0) + " degrees",
                either(recording, "give samples of sway", "name the sway column with " + setting("column")));
  }
  if (peak_deg > max_deg) {
    const auto at = (upright - *low > *high - upright ? low : high) - sway.rad.begin();
    if (!in_memory(recording) && peak_to_peak_deg < 2.0 * max_plausible_deg)
      throw Error(Code::value_invalid, where(recording),
                  sway.column + " is about " + three_digits(middle / sim::rad_per_deg) + " degrees, beyond lying flat",
                  "if that is upright, give " + setting("detrend") + " offset; " + other);
    throw Error(Code::value_invalid, where(recording),
                sway.column + " reaches " + three_digits(peak_deg) + " degrees, beyond lying flat, at sample " +
                    std::to_string(at + 1),
                in_memory(recording) ? other
                                     : other + std::string("; if it stands for a missing value, give " +
                                                           setting("missing") + " NUMBER and " + setting("fill_gaps")));
  }
  if (peak_deg > max_plausible_deg) {
    recording.is_large = true;
    add_caution(recording.warnings, "large_sway",
                "the sway reaches " + three_digits(peak_deg) + " degrees, too far for a standing body; " + other);
  } else if (guessed) {
    check_assumed_unit(sway, peak_to_peak_deg, other, recording);
  }
  const double if_radians_deg = peak_to_peak_deg / sim::rad_per_deg;
  if (guessed && peak_to_peak_deg < min_plausible_deg && if_radians_deg > min_plausible_deg)
    throw Error(Code::unit_unknown, where(recording),
                sway.column + " has no unit, and is " + three_digits(peak_to_peak_deg) +
                    " degrees peak to peak if it is in degrees, " + three_digits(if_radians_deg) + " if in radians",
                "give " + setting("unit") + " rad or " + setting("unit") + " deg; if these are positions, give " +
                    setting("com_height"));
  if (peak_to_peak_deg < min_plausible_deg) {
    add_caution(recording.warnings, "small_sway",
                "the sway is only " + three_digits(peak_to_peak_deg) + " degrees peak to peak, " +
                    three_digits(if_radians_deg) + " if these are radians; " + other);
  }
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
    recording.change = describe_change(table, sway, time, clock.rate_hz);
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
  const auto with_missing = [read, clock, separate, missing_value = options.missing_value,
                             unit_s = time < 0 ? 1.0 : time_unit_s(table.name(time)),
                             samples = signal.rad.size()](int column, std::size_t step) {
    if (step > 1 && (!clock.place.empty() || separate->rows() > 0)) return std::vector<double>();
    if (separate->has(column)) return separate->at(column, clock, unit_s, samples);
    return place_evenly(read_numbers(*read, column, missing_value, step), clock);
  };
  check_hip(table, time, source, signal.rad, options, with_missing, recording);
  if (options.invert_sway)
    for (double& value : signal.rad) value = -value;
  if (!options.tilt_column.empty()) {
    read_tilt(table, named_column(table, options.tilt_column, recording.file, setting("tilt_column")), sway,
              with_missing, options, recording);
  } else if (options.find_tilt) {
    look_for_tilt(table, time, source.columns, with_missing, options, recording);
  }
  if ((options.tilt_unit || options.invert_tilt) && recording.signals.find(platform_tilt) == nullptr)
    throw Error(Code::setting_missing, recording.file,
                "no tilt is read for " + setting("tilt_unit") + " or " + setting("invert") + " tilt",
                "name its column with " + setting("tilt_column"));
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
      throw Error(Code::value_invalid, "recording", "sample " + std::to_string(k) + " is not finite",
                  "interpolate missing samples");
  const Signal<double>& sway = recording.signals.add({com_sway, "sway", {sway_rad.begin(), sway_rad.end()}});
  check_size(sway, false, mean_is_upright, false, recording);
  return recording;
}

}  // namespace decid::recording
