// Sources of the sway: see sway_source.hpp.
#include "recording/detail/sway/sway_source.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>

#include "base/error.hpp"
#include "base/setting.hpp"
#include "recording/detail/sway/sway_name.hpp"
#include "recording/table/columns.hpp"
#include "recording/table/detail/candidates.hpp"
#include "recording/table/detail/quaternion.hpp"
#include "recording/table/detail/trials.hpp"

namespace decid::recording {

namespace {

constexpr auto sway_names = {"com_sway",
                             "com_x",
                             "sway",
                             "body_sway",
                             "com_ap",
                             "sway_ap",
                             "com_angle",
                             "sway_angle",
                             "a_bs",
                             "com",
                             "ksp",
                             "k\xC3\xB6rperschwerpunkt",
                             "schwankung",
                             "body_sway_angle",
                             "bodysway",
                             "swayap",
                             "cog_x",
                             "cog_ap",
                             "cog_angle",
                             "cog",
                             "body_angle",
                             "body_lean",
                             "lean_angle",
                             "neigung",
                             "k\xC3\xB6rperneigung"};

/// Throws Error for a frequency response, whose table has lines of frequencies instead of samples.
void refuse_response(const Table& table, const std::string& where) {
  const auto has = [&](std::string_view part) {
    return std::ranges::any_of(table.names(), [&](const std::string& name) { return words(name).front() == part; });
  };
  if (has("frequency") && has("gain"))
    throw Error(Code::file_unsupported, where, "is a frequency response, not a recording",
                "fit it with " + setting("frf") + " " + where);
}

/// Returns true for a force or a torque, which is never a sway.
bool is_load(const char* quantity) {
  return quantity != nullptr && one_of(quantity, {a_force, a_torque});
}

/// Returns an advice for a file of a force plate: a bare "x_mm" beside "Fz" is a centre of pressure. Empty for others.
std::string force_plate_advice(const Table& table) {
  const auto& names = table.names();
  if (!table.has_header() ||
      std::ranges::none_of(names, [](const std::string& name) { return is_load(other_quantity(name)); }))
    return {};
  return "; a force plate's centre of pressure is not the sway: estimate the centre of mass first";
}

/// Throws Error if every candidate is a quantity by its name that is neither an angle nor the length of a body's place.
void refuse_other_quantities(const Table& table, const std::vector<int>& candidates, const std::string& where) {
  std::string list;
  bool has_pressure = false;
  for (const int column : candidates) {
    const std::string& name = table.name(column);
    const char* quantity = other_quantity(name);
    if (!table.has_header() || quantity == nullptr) return;
    const bool is_pressure = std::string_view(quantity) == centre_of_pressure;
    if (find_metres_per_unit(name) && !is_pressure) return;
    has_pressure = has_pressure || is_pressure;
    if (list.size() < 200) list += (list.empty() ? "'" : ", '") + name + "' is " + quantity;
  }
  throw Error(Code::column_unsuitable, where, "has no column of angles by the names: " + list,
              has_pressure ? "estimate the centre of mass first, and name its column: a force plate's centre of "
                             "pressure moves farther and faster"
                           : "convert the sway to degrees, or name its column with " + setting("column") +
                                 " and give " + setting("unit"));
}

/// Lists the columns, except the time and the tilt, that are another quantity by their names; empty without one.
std::string other_quantities(const Table& table, int time, const std::vector<int>& tilts) {
  std::string list;
  for (int column = 0; column < table.columns() && list.size() < 200; ++column) {
    const char* quantity = other_quantity(table.own_name(column));
    if (column == time || std::ranges::find(tilts, column) != tilts.end() || !table.has_header() || quantity == nullptr)
      continue;
    list += (list.empty() ? "'" : ", '") + table.name(column) + "' is " + quantity;
  }
  return list;
}

/// Returns the advice to read a position of the centre of mass; empty without one.
std::string position_advice(const Table& table, int time) {
  const std::vector<int> centres = centre_of_mass_columns(table, length_candidates(table, time));
  if (centres.empty()) return {};
  return "; '" + table.name(centres.front()) +
         "' is a position of the centre of mass: name it, and give its height as " + setting("com_height");
}

/// Throws Error for several columns that may be the sway. Leaves out ankle angles, which cannot be, if several others
/// remain.
[[noreturn]] void refuse_several(const Table& table, int time, std::vector<int> candidates, const std::string& where) {
  const auto is_ankle = [&](int column) { return is_ankle_name(table.own_name(column)); };
  if (candidates.size() > 1 + static_cast<std::size_t>(std::ranges::count_if(candidates, is_ankle)))
    std::erase_if(candidates, is_ankle);
  // "0,01,0,02": half as many names as cells, so they are not a header.
  const bool decimal_commas = !table.has_header() && table.columns() % 2 == 0 && table.arrays().empty();
  std::string list;
  for (const int column : candidates)
    list += list.size() > 200 ? "" : (list.empty() ? "'" : ", '") + table.name(column) + "'";
  throw Error(Code::column_ambiguous, where, "has several columns that may be the sway: " + list,
              std::string("name one with " + setting("column") + ", or the sway's parts with " + setting("leg") +
                          " and " + setting("trunk") + ", or " + setting("hip") + " and " + setting("shoulder")) +
                  (decimal_commas ? "; if its numbers have decimal commas, save it with semicolons between them" : "") +
                  position_advice(table, time) + force_plate_advice(table) + trial_advice(table));
}

/// Throws Error for a table without a column that may be the sway. tilts: the platform's columns.
[[noreturn]] void refuse_none(const Table& table, int time, const std::vector<int>& tilts,
                              const RecordingOptions& options, const std::string& where) {
  const std::string unread = table.unread().empty() ? std::string() : "; not read: " + table.unread();
  const std::string add = unread.empty()
                              ? "add the sway, or name it with " + setting("column")
                              : "save the sway as a vector of real numbers, or name it with " + setting("column");
  if (sway_candidates(table, time).empty())
    throw Error(Code::column_missing, where, "has a time column but no sway column" + unread, add);
  if (tilts.empty())
    throw Error(Code::column_missing, where,
                "has no sway column except '" + options.trial_column + "' of " + setting("trial_column") + unread, add);
  const std::string problem =
      (tilts.size() == 1 ? "has a column of the platform's tilt, '" + table.name(tilts.front()) + "', but"
                         : "has " + std::to_string(tilts.size()) + " columns of the platform's tilt by their names, '" +
                               table.name(tilts.front()) + "' and '" + table.name(tilts.back()) + "', but") +
      " no sway column" + unread;
  const std::string others = other_quantities(table, time, tilts);
  if (others.empty()) throw Error(Code::column_missing, where, problem, add);
  throw Error(Code::column_missing, where, problem + "; by their names " + others,
              "convert the sway to degrees; or name its column with " + setting("column") + ", and give " +
                  setting("unit") + " if it is an angle, or " + setting("unit") + " and " + setting("com_height") +
                  " if it is a length in mm, cm or m");
}

/// Returns the columns that may be a position of the centre of mass: lengths by their names, and among them those that
/// are called so. Empty if there are none, if `named` (-1: no column) has no unit, or beside forces.
std::vector<int> position_candidates(const Table& table, int time, int named) {
  const std::vector<int> lengths = length_candidates(table, time);
  if (std::ranges::find(lengths, named) != lengths.end()) return {named};
  std::vector<int> centres = centre_of_mass_columns(table, lengths);
  if (!centres.empty()) return centres;
  const bool may_be_length = named >= 0 && !unit_in(table.own_name(named));
  return may_be_length || !force_plate_advice(table).empty() ? std::vector<int>() : lengths;
}

/// Includes displacements: they may be the only column, and their unit is checked later.
int find_sway(const Table& table, int time, const RecordingOptions& options, Recording& recording) {
  const int named = find_named(table, time, sway_names, recording.file, setting("column"));
  std::vector<int> candidates;
  // A given unit of lengths is for a column without one.
  if (options.com_height_m && !(options.metres_per_unit && named >= 0))
    candidates = position_candidates(table, time, named);
  if (candidates.empty() && named >= 0) return named;
  if (candidates.size() == 1 && (candidates.front() == named || !centre_of_mass_columns(table, candidates).empty()))
    return candidates.front();
  if (candidates.empty()) candidates = sway_candidates(table, time);
  if (candidates.empty()) refuse_none(table, time, {}, options, recording.file);
  const std::vector<int> tilts = tilt_columns(table, time);
  for (const int tilt : tilts) std::erase(candidates, tilt);
  const std::vector<int> quaternions = quaternion_columns(table, candidates);
  for (const int quaternion : quaternions) std::erase(candidates, quaternion);
  if (candidates.empty() && !quaternions.empty()) refuse_quaternion(table, quaternions.front(), recording.file);
  if (!options.trial_column.empty())
    for (const int column : trial_columns(table, options.trial_column, recording.file)) std::erase(candidates, column);
  if (candidates.size() > 1) refuse_other_quantities(table, candidates, recording.file);
  if (candidates.size() > 1) refuse_several(table, time, candidates, recording.file);
  if (candidates.empty()) refuse_none(table, time, tilts, options, recording.file);
  const int sway = candidates.front();
  if (table.has_header()) {
    add_info(recording.warnings, "column_assumed",
             "column '" + table.name(sway) + "' is assumed to be the sway: it is the only candidate" +
                 (!tilts.empty() ? " except the platform's tilt" : ""));
  }
  return sway;
}

void refuse_same_column(const Table& table, const std::vector<int>& columns, const std::string& where) {
  for (std::size_t i = 0; i < columns.size(); ++i)
    if (std::find(columns.begin(), columns.begin() + static_cast<std::ptrdiff_t>(i), columns[i]) !=
        columns.begin() + static_cast<std::ptrdiff_t>(i))
      throw Error(Code::setting_conflict, where, "'" + table.name(columns[i]) + "' is named for two signals",
                  "name a column for each");
}

void warn_of_axes(const Table& table, const std::vector<int>& columns, Recording& recording) {
  const std::string& first = table.name(columns.front());
  for (const int column : columns) {
    const std::string& name = table.name(column);
    const char axis = axis_of(first), other = axis_of(name);
    if (axis == '\0' || other == '\0' || axis == other) continue;
    add_caution(recording.warnings, "axes_differ",
                first + " and " + name + " have different axes: name columns in the direction of the tilt");
    return;
  }
}

bool names_segments(const RecordingOptions& options) {
  return !options.leg_column.empty() || !options.trunk_column.empty();
}

bool names_markers(const RecordingOptions& options) {
  return !options.hip_column.empty() || !options.shoulder_column.empty();
}

/// Throws Error for options that contradict each other, lack another one, or have no meaning.
void check_options(const RecordingOptions& options) {
  const bool segments = names_segments(options);
  const bool markers = names_markers(options);
  if ((segments && markers) || ((segments || markers) && (!options.column.empty() || options.com_height_m))) {
    throw Error(Code::setting_conflict,
                setting("column") + ", " + setting("com_height") + ", " + setting("leg") + " and " + setting("trunk") +
                    ", " + setting("hip") + " and " + setting("shoulder"),
                "contradict each other: they name several sources of the sway", "give one of them");
  }
  if (segments && (options.leg_column.empty() || options.trunk_column.empty()))
    throw Error(Code::setting_missing, setting("leg") + ", " + setting("trunk"), "one is missing", "give both columns");
  if (markers && (options.hip_column.empty() || options.shoulder_column.empty()))
    throw Error(Code::setting_missing, setting("hip") + ", " + setting("shoulder"), "one is missing",
                "give both columns");
  if (markers && !options.body_height_m)
    throw Error(Code::setting_missing, setting("hip") + ", " + setting("shoulder"),
                "the lengths of the segments are unknown", "give " + setting("mass") + " and " + setting("height"));
  if (!options.ankle_column.empty() && !markers && !options.com_height_m)
    throw Error(Code::setting_missing, setting("ankle"), "no positions refer to it",
                "give " + setting("com_height") + ", or " + setting("hip") + " and " + setting("shoulder"));
  if (options.unit && (markers || options.com_height_m))
    throw Error(Code::setting_conflict, setting("unit"), "is a unit of angles; the sway comes from positions",
                "give mm, cm or m, or leave it out");
  if (options.metres_per_unit && segments)
    throw Error(Code::setting_conflict, setting("unit"), "is a unit of positions; the sway comes from angles",
                "give deg, rad or mrad, or leave it out");
  if (options.com_height_m && !(*options.com_height_m > 0.0 && std::isfinite(*options.com_height_m)))
    throw Error(Code::setting_out_of_range, setting("com_height"), "is " + three_digits(*options.com_height_m) + " m",
                "give metres above the ankles");
  // Without hip and shoulder the height is the person's, which programs give for every recording.
  if (options.body_height_m && !(*options.body_height_m > 0.0 && std::isfinite(*options.body_height_m)))
    throw Error(Code::setting_out_of_range, setting("height"), "is " + three_digits(*options.body_height_m) + " m",
                "give the person's height in metres");
}

/// Throws Error for a centre of mass higher than the person, and warns of a height that no standing person has: 0.4 to
/// 0.7 of the person's. If that is unknown, notes a height outside of 0.4 to 1.3 m, which a child or a robot may have.
/// Winter's proportions give 0.55.
void check_com_height(const RecordingOptions& options, Recording& recording) {
  constexpr double min_ratio = 0.4, max_ratio = 0.7, min_m = 0.4, max_m = 1.3;
  if (!options.com_height_m) return;
  const double height_m = *options.com_height_m;
  const std::string given = setting("com_height") + " is " + three_digits(height_m) + " m";
  if (options.body_height_m) {
    const double body_m = *options.body_height_m;
    if (height_m > body_m)
      throw Error(Code::setting_out_of_range, setting("com_height"),
                  "is " + three_digits(height_m) + " m, above the person's height of " + three_digits(body_m) + " m",
                  "give the height of the centre of mass above the ankles, about " + three_digits(0.55 * body_m) +
                      " m for this person");
    if (height_m < min_ratio * body_m || height_m > max_ratio * body_m)
      add_caution(recording.warnings, "implausible_com_height",
                  given + ", " + three_digits(100.0 * height_m / body_m) + "% of the person's height of " +
                      three_digits(body_m) + " m; a centre of mass is at about 55% above the ankles, " +
                      three_digits(0.55 * body_m) + " m");
  } else if (height_m < min_m || height_m > max_m) {
    add_info(recording.warnings, "implausible_com_height",
             given + ": an adult's centre of mass is 0.4 to 1.3 m above the ankles, and 0.99 m at a height of 1.8 m");
  }
}

}  // namespace

SwaySource find_sway_source(const Table& table, int time, const RecordingOptions& options, Recording& recording,
                            int axis) {
  using Kind = SwaySource::Kind;
  const std::string& where = recording.file;
  check_options(options);
  check_com_height(options, recording);
  SwaySource source;
  const auto add = [&](const std::string& column, const std::string& setting_name) {
    source.columns.push_back(named_column(table, column, where, setting_name));
  };
  if (names_segments(options)) {
    source.kind = Kind::segments;
    add(options.leg_column, setting("leg"));
    add(options.trunk_column, setting("trunk"));
    for (const int column : source.columns) refuse_quaternion(table, column, where);
  } else if (names_markers(options)) {
    source.kind = Kind::markers;
    add(options.hip_column, setting("hip"));
    add(options.shoulder_column, setting("shoulder"));
  } else {
    source.kind = options.com_height_m ? Kind::displacement : Kind::angle;
    if (axis >= 0) {
      source.columns.push_back(axis);
    } else if (options.column.empty()) {
      refuse_response(table, where);
      source.columns.push_back(find_sway(table, time, options, recording));
    } else {
      add(options.column, setting("column"));
      refuse_quaternion(table, source.columns.front(), where);
    }
    const std::string& name = table.name(source.columns.front());
    if (!options.com_height_m) refuse_ankle(name, where);
    if (const char* quantity = other_quantity(name); options.com_height_m && is_load(quantity))
      throw Error(Code::column_unsuitable, where, name + " is " + quantity + " by its name, not a position",
                  "name a position of the centre of mass with " + setting("column"));
    if (options.com_height_m && other_quantity(name) == centre_of_pressure)
      static_cast<void>(find_unit(name, {}, where, setting("unit")));  // throws: not a position of the centre of mass
    warn_of_part(name, recording);
  }
  if (!options.ankle_column.empty()) add(options.ankle_column, setting("ankle"));
  refuse_same_column(table, source.columns, where);
  warn_of_axes(table, source.columns, recording);
  const int first = source.columns.front();
  for (const int column : source.columns) {
    if (table.rows(column) == table.rows(first)) continue;
    throw Error(Code::size_mismatch, where,
                table.name(first) + " has " + std::to_string(table.rows(first)) + " values, " + table.name(column) +
                    " " + std::to_string(table.rows(column)),
                "name signals of equal length");
  }
  return source;
}

}  // namespace decid::recording
