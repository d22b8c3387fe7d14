// The clock of a recording: see find_clock.hpp.
#include "recording/detail/find_clock.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <utility>

#include "base/error.hpp"
#include "base/setting.hpp"
#include "recording/table/columns.hpp"
#include "recording/table/detail/trials.hpp"

namespace decid::recording {

namespace {

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

}  // namespace

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
    const auto is_given = [&](double factor) {
      return std::abs(factor * clock.rate_hz - *options.rate_hz) <= rate_tolerance * factor * clock.rate_hz;
    };
    const char* const unit = is_given(1e3) ? "milliseconds" : is_given(1e6) ? "microseconds" : "nanoseconds";
    if (is_given(1e3) || is_given(1e6) || is_given(1e9)) {
      add_info(recording.warnings, "rate_differs",
               "the column " + name + " has the given rate, " + six_digits(*options.rate_hz) + " Hz, in " + unit);
    } else if (!is_given(1.0)) {
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

}  // namespace decid::recording
