// Columns of a table by their names: the time, the tilt, and the columns that the user names.
// Not installed.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recording/recording.hpp"
#include "recording/table/detail/units.hpp"
#include "recording/table/table.hpp"

namespace decid::recording {

/// Rates that differ by less are equal: over a trial of 121 s the difference is one sample.
inline constexpr double rate_tolerance = 1e-4;

/// The allowed sample rates of recordings.
inline constexpr double lowest_rate_hz = 1.0, highest_rate_hz = 100'000.0;
inline bool is_sample_rate(double rate_hz) {
  return rate_hz >= lowest_rate_hz && rate_hz <= highest_rate_hz;
}

/// Returns the integer within a millionth of a rate, else the rate itself.
double near_whole(double rate_hz);

/// Formats six significant digits: "50", "127.4".
std::string six_digits(double value);
/// Formats three significant digits, for measured figures: "25.9", "0.0165".
std::string three_digits(double value);

/// Returns a column's name in parts, lower case: "COM_x (deg)" -> com, x, deg. Drops an index of MATLAB's at its end:
/// "sway_deg(:,2)" -> sway, deg.
std::vector<std::string> words(std::string_view name);
/// Returns words(name) with nothing between them: "Frame No." -> frameno.
std::string letters_of(std::string_view name);
/// Returns words(name), then the parts that begin with a capital: "LAnkleAngle_deg" -> lankleangle, deg, l, ankle,
/// angle. It splits units too ("mV"), so read units with words().
std::vector<std::string> words_in(std::string_view name);
/// Returns true if the list has the word.
bool one_of(std::string_view word, std::initializer_list<std::string_view> list);
/// Lists the names of a table's columns except one (-1: all), for messages.
std::string to_list(const Table& table, int without);

[[noreturn]] void refuse_several(const Table& table, const std::vector<int>& columns, const std::string& name,
                                 const std::string& where, const std::string& setting_name);
/// Returns the advice to read each element of an array as a recording: "; --trial trials makes ..."; empty without an
/// array.
std::string trial_advice(const Table& table);
/// Returns the first column whose own name without its unit is the earliest of `names` that occurs; -1 without such a
/// column. Skips the column `without`. Throws Error for several columns of one name.
int find_named(const Table& table, int without, std::initializer_list<const char*> names, const std::string& where,
               const std::string& setting_name);
/// Returns the column that the user named: by its name, its path in the file, its name in another case, without its
/// unit or without a subject's name before a colon, or its number. Throws Error for no column or several. `where` names
/// the file, `setting_name` the setting of columns: "--column".
int named_column(const Table& table, const std::string& column, const std::string& where,
                 const std::string& setting_name);

/// Returns true for "time", "time_ms", "Time since start (s)", "t" and "t (ms)", but not for "T_ankle".
bool is_time_name(std::string_view name);
/// Returns the sample rate that a table states outside of its columns, if any. Throws Error for several rates, and for
/// a rate outside of 1 to 100,000 Hz. `where` names the file, `setting_name` the setting of rates: "--rate".
std::optional<StatedRate> stated_rate(const Table& table, const std::string& where, const std::string& setting_name);
/// Returns the time column, or -1.
int find_time(const Table& table);
/// Returns true for "nsec", "stamp.nanosec" and "time_nsecs": nanoseconds, which start again each second.
bool is_nanoseconds_name(std::string_view name);
/// Returns the column of the nanoseconds beside one of whole seconds, as ROS writes times: "stamp.nanosec" beside
/// "stamp.sec"; -1 without one.
int nanoseconds_beside(const std::vector<std::string>& names, int seconds);
/// Returns the column called tilt, platform, Plattform or similar, except `without`, or -1. Throws Error for several
/// columns of one name.
int find_tilt_column(const Table& table, int without, const std::string& where, const std::string& setting_name);
/// Returns all columns with such a name, except `without`.
std::vector<int> tilt_columns(const Table& table, int without);

/// Returns the seconds in one unit of a time column, by its name.
double time_unit_s(std::string_view name);

}  // namespace decid::recording
