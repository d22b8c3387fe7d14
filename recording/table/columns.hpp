// Columns of a table by their names: which is the time, in which unit a column is, which one the user means.
// Not installed.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recording/recording.hpp"
#include "recording/table/table.hpp"

namespace decid::recording {

/// Rates that differ by less are equal: over a trial of 121 s the difference is a sample.
inline constexpr double rate_tolerance = 1e-4;

/// Sample rates that recordings may have.
inline constexpr double lowest_rate_hz = 1.0, highest_rate_hz = 100'000.0;
inline bool is_sample_rate(double rate_hz) {
  return rate_hz >= lowest_rate_hz && rate_hz <= highest_rate_hz;
}

/// The whole number that a rate is within a millionth, else the rate itself.
double near_whole(double rate_hz);

/// Six significant digits: "50", "127.4".
std::string six_digits(double value);
/// Three significant digits, for figures that are measured: "25.9", "0.0165".
std::string three_digits(double value);

/// A column's name in its parts, lower case: "COM_x (deg)" -> com, x, deg. An index of MATLAB's at its end is none of
/// them: "sway_deg(:,2)" -> sway, deg.
std::vector<std::string> words(std::string_view name);
/// Returns words(name), then the parts that begin with a capital: "LAnkleAngle_deg" -> lankleangle, deg, l, ankle,
/// angle. It splits units too ("mV"), so read units with words().
std::vector<std::string> words_in(std::string_view name);
bool one_of(std::string_view word, std::initializer_list<std::string_view> list);
/// The unit that a name ends in, if any.
std::optional<Unit> unit_in(std::string_view name);
/// Returns the quantity in a column that holds no angle by its name: "a length", "a torque", "in counts". Returns
/// nullptr for all other names, and for a column called just "m".
const char* other_quantity(std::string_view name);
/// That of a force plate's point of force, an angle or a length by its unit.
inline constexpr char centre_of_pressure[] = "a centre of pressure";
/// The unit of a column of angles: the one given, else the name's, if any. Throws Error for a name that says that it is
/// none ("COM_x (mm)", "sway_deg_s", "tilt speed"); `where` names the file, `setting` how units are given: "--unit".
std::optional<Unit> unit_of(const std::string& name, std::optional<Unit> given, const std::string& where,
                            const std::string& setting);
/// That of a table's column, which is the file's own if the column's name has none, and degrees, which is noted, if
/// neither has; that a given unit is not the name's is warned of. Throws Error as unit_of.
Unit angle_unit(const Table& table, int column, std::optional<Unit> given, const std::string& setting,
                Recording& recording);
/// Metres in the unit of length that a name ends in, if it does.
std::optional<double> metres_in_unit_of(std::string_view name);
/// One of it in radians.
double rad_in(Unit unit);
/// "com_x" of "COM_x (deg)".
std::string name_without_unit(std::string_view name);
/// "COM x" of "COM x (deg)" and "COM x [mm]".
std::string name_before_unit(std::string_view name);
/// The names of a table's columns except one (-1: of all), to be shown.
std::string list_of(const Table& table, int without);

[[noreturn]] void refuse_several(const Table& table, const std::vector<int>& columns, const std::string& name,
                                 const std::string& where, const std::string& setting);
/// The advice to read each element of an array as a recording: "; --trial trials makes ..."; empty without an array.
std::string trial_advice(const Table& table);
/// The first column, but one, whose own name without its unit is the first of these that there is; -1 if there is none.
/// Throws Error for several of one name.
int find_named(const Table& table, int without, std::initializer_list<const char*> names, const std::string& where,
               const std::string& setting);
/// The column that the user named, by its name, its path in the file, its name in other case or without its unit in
/// brackets, or its number. Throws Error if there is none or more than one. `where` names the file, `setting` how
/// columns are named: "--column".
int named_column(const Table& table, const std::string& column, const std::string& where, const std::string& setting);

/// "time", "time_ms", "Time since start (s)"; "t", "t (ms)", but not "T_ankle".
bool is_time_name(std::string_view name);
/// The sample rate that a table states beside its columns, if it does. Throws Error for several, and for one that is
/// not from 1 to 100,000 Hz. `where` names the file, `setting` how rates are given: "--rate".
std::optional<StatedRate> stated_rate(const Table& table, const std::string& where, const std::string& setting);
/// The column of time, or -1.
int find_time(const Table& table);
/// The column called tilt, platform, Plattform or the like, but one, or -1. Throws Error for several of one name.
int find_tilt_column(const Table& table, int without, const std::string& where, const std::string& setting);

/// Seconds in one unit of a column of time, by its name.
double time_unit_s(std::string_view name);

}  // namespace decid::recording
