// The sway in radians: see read_sway.hpp.
#include "recording/detail/sway/read_sway.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "base/error.hpp"
#include "base/math/statistics.hpp"
#include "base/setting.hpp"
#include "base/text.hpp"
#include "recording/detail/sway/sway_name.hpp"
#include "recording/detail/sway/sway_size.hpp"
#include "recording/quality/detail/block_means.hpp"
#include "recording/table/columns.hpp"
#include "sim/double_pendulum.hpp"
#include "sim/segments.hpp"

namespace decid::recording {

namespace {

/// Returns "mm", "cm" or "m", or "0.3048 m".
std::string length_name(double metres) {
  if (metres == 1e-3) return "mm";
  if (metres == 1e-2) return "cm";
  return metres == 1.0 ? "m" : format("%g m", metres);
}

/// Returns a column of lengths in metres.
std::vector<double> read_metres(const Table& table, int column, const RecordingOptions& options,
                                const std::function<std::vector<double>(int)>& read, Recording& recording) {
  const std::string& name = table.name(column);
  const std::optional<double> named = find_metres_per_unit(name);
  const std::optional<double> metres = options.metres_per_unit ? options.metres_per_unit : named;
  if (options.metres_per_unit && ((named && *named != *metres) || (!named && (unit_in(name) || other_quantity(name)))))
    add_caution(
        recording.warnings, "unit_differs",
        name + " has a unit in its name that differs from " + setting("unit") + "; decid uses " + setting("unit"));
  if (!metres)
    throw Error(Code::unit_unknown, recording.file, "the name of " + name + " has no unit of length",
                "give " + setting("unit") + " mm, cm or m");
  std::vector<double> values = read(column);
  for (double& value : values) value *= *metres;
  return values;
}

/// Returns the angles of displacements at the top of a rod of this length.
std::vector<double> angles(const std::vector<double>& displacement_m, double length_m, const std::string& what,
                           const Recording& recording) {
  std::vector<double> result;
  result.reserve(displacement_m.size());
  for (const double x : displacement_m) {
    if (!(std::abs(x) < length_m)) {
      const std::string problem =
          what + " is " + three_digits(x) + " m from the upright, at a height of " + three_digits(length_m) + " m";
      refuse_differing_unit(recording, problem);
      throw Error(Code::value_invalid, recording.file, problem,
                  "check units and columns; positions count from the ankle (" + setting("ankle") + " COLUMN)");
    }
    result.push_back(std::asin(x / length_m));
  }
  return result;
}

/// Returns the sway of a body of any height: Winter's proportions hold for all heights.
std::vector<double> sway_of(const std::vector<double>& leg, const std::vector<double>& trunk) {
  const sim::DoubleBody body(sim::make_segments({}));
  std::vector<double> sway(leg.size());
  for (std::size_t k = 0; k < leg.size(); ++k) sway[k] = body.centre_of_mass(leg[k], trunk[k]);
  return sway;
}

std::vector<double> difference(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> result(a.size());
  for (std::size_t k = 0; k < a.size(); ++k) result[k] = a[k] - b[k];
  return result;
}

/// Returns the standard deviation of block means about their line: without a sensor's noise, offset and drift.
double slow_deviation(const std::vector<double>& values) {
  constexpr std::size_t blocks = 240;
  std::vector<double> means = block_means(values, std::max<std::size_t>(1, values.size() / blocks));
  if (means.size() < 3) return 0.0;
  const double middle = 0.5 * static_cast<double>(means.size() - 1), centre = mean(means);
  double with_place = 0.0, places = 0.0;
  for (std::size_t i = 0; i < means.size(); ++i) {
    const double place = static_cast<double>(i) - middle;
    with_place += place * (means[i] - centre);
    places += place * place;
  }
  double squares = 0.0;
  for (std::size_t i = 0; i < means.size(); ++i) {
    const double off = means[i] - centre - with_place / places * (static_cast<double>(i) - middle);
    squares += off * off;
  }
  return std::sqrt(squares / static_cast<double>(means.size()));
}

/// Warns if the hip moves, because the model is one segment. `columns`: those of leg and trunk, or empty.
void warn_of_hip(const std::vector<double>& leg, const std::vector<double>& trunk, const std::vector<double>& sway,
                 const std::string& columns, Recording& recording) {
  constexpr double max_ratio = 0.2;
  const double of_hip = slow_deviation(difference(trunk, leg)), of_sway = slow_deviation(sway);
  if (of_hip > max_ratio * of_sway)
    add_caution(recording.warnings, "hip_moves",
                "the hip angle" + columns + " varies by " + three_digits(of_hip / sim::rad_per_deg) +
                    " degrees rms, the sway by " + three_digits(of_sway / sim::rad_per_deg) +
                    ": the model is one segment, so these values are biased, most of all stiffness and delay");
}

/// Returns the sway of both segments. Warns if the hip moves.
std::vector<double> join_segments(const std::vector<double>& leg, const std::vector<double>& trunk,
                                  Recording& recording) {
  std::vector<double> sway = sway_of(leg, trunk);
  warn_of_hip(leg, trunk, sway, "", recording);
  return sway;
}

/// Removes steps of about 360 degrees, which programs cause that keep angles within one turn. Returns whether there
/// were any. Ignores NaN.
bool unwrap(std::vector<double>& rad) {
  constexpr double turn = 360.0 * sim::rad_per_deg, margin = 60.0 * sim::rad_per_deg;
  double turns = 0.0, sum = 0.0;
  std::size_t count = 0;
  std::optional<double> before;
  bool any = false;
  for (double& value : rad) {
    if (std::isnan(value)) continue;
    const double step = before ? value + turns * turn - *before : 0.0;
    if (std::abs(std::abs(step) - turn) < margin) {
      turns += step > 0.0 ? -1.0 : 1.0;
      any = true;
    }
    if (turns != 0.0) value += turns * turn;  // keeps -0
    before = value;
    sum += value;
    ++count;
  }
  if (!any) return false;
  const double whole = turn * std::round(sum / static_cast<double>(count) / turn);
  for (double& value : rad) value -= whole;
  return true;
}

/// Returns angles of leg or trunk, rad.
std::vector<double> read_angles(const Table& table, int column, const RecordingOptions& options,
                                const std::function<std::vector<double>(int)>& read, Recording& recording) {
  const std::string& name = table.name(column);
  const double unit_rad = rad_in(angle_unit(table, column, options.unit, setting("unit"), recording));
  if (!options.unit && !unit_in(name) && !table.unit() && is_position_name(name))
    add_caution(recording.warnings, "perhaps_a_length",
                name + " is a position by its name; decid reads it in degrees: if it is a length, give " +
                    setting("com_height") + " and " + setting("unit") + " mm, cm or m; if not, " + setting("unit") +
                    " deg");
  std::vector<double> values = read(column);
  for (double& value : values) value *= unit_rad;
  if (unwrap(values))
    add_info(recording.warnings, "unwrapped", name + " jumps by 360 degrees: decid removed whole turns");
  return values;
}

/// Returns the angles of a column by its own unit, else by `unit`, in rad; empty for a length or another number of
/// samples.
std::vector<double> angles_beside(const Table& table, int column, std::size_t samples, Unit unit,
                                  const ReadColumn& read) {
  const std::string& name = table.name(column);
  if (find_metres_per_unit(name)) return {};
  std::vector<double> values = read(column, 1);
  if (values.size() != samples) return {};
  for (double& value : values) value *= rad_in(unit_in(name).value_or(unit));
  unwrap(values);
  return values;
}

/// Columns of leg and trunk that a file has beside the sway, rad, and the sway: the samples that all three have.
struct SegmentsBeside {
  std::string columns{};
  std::vector<double> leg{}, trunk{}, sway{};
};

/// Returns the columns that are named leg and trunk, if they are angles with the sway's number of samples. unit: of
/// columns whose name has none.
std::optional<SegmentsBeside> segments_beside(const Table& table, int time, const std::vector<double>& sway_rad,
                                              Unit unit, const ReadColumn& read, const std::string& where) {
  try {
    const int leg_column =
        find_named(table, time, {"leg", "leg_angle", "leg_sway", "leg_tilt", "a_ls", "bein", "beinwinkel"}, where, "");
    const int trunk_column = find_named(
        table, time, {"trunk", "trunk_angle", "trunk_sway", "trunk_tilt", "a_ts", "rumpf", "rumpfwinkel"}, where, "");
    if (leg_column < 0 || trunk_column < 0) return {};
    const std::vector<double> leg = angles_beside(table, leg_column, sway_rad.size(), unit, read),
                              trunk = angles_beside(table, trunk_column, sway_rad.size(), unit, read);
    if (leg.empty() || trunk.empty()) return {};
    SegmentsBeside found{.columns = table.name(leg_column) + " and " + table.name(trunk_column)};
    for (std::size_t k = 0; k < leg.size(); ++k) {
      if (std::isnan(leg[k]) || std::isnan(trunk[k])) continue;
      found.leg.push_back(leg[k]);
      found.trunk.push_back(trunk[k]);
      found.sway.push_back(sway_rad[k]);
    }
    return found;
  } catch (const Error&) {  // words, infinite numbers, or several columns of a name
    return {};
  }
}

}  // namespace

void check_hip(const Table& table, int time, const SwaySource& source, const std::vector<double>& sway_rad,
               const RecordingOptions& options, const ReadColumn& read, Recording& recording) {
  constexpr double max_difference = 0.2;
  if (source.kind != SwaySource::Kind::angle && source.kind != SwaySource::Kind::displacement) return;
  const Unit of_sway =
      options.unit.value_or(unit_in(table.name(source.columns.front())).value_or(table.unit().value_or(Unit::degree)));
  const std::optional<SegmentsBeside> beside = segments_beside(table, time, sway_rad, of_sway, read, recording.file);
  if (!beside || 2 * beside->sway.size() < sway_rad.size()) return;
  // Angles against the platform or between the segments have another centre of mass.
  const std::vector<double> off = difference(sway_of(beside->leg, beside->trunk), beside->sway);
  if (slow_deviation(off) > max_difference * slow_deviation(beside->sway)) return;
  warn_of_hip(beside->leg, beside->trunk, beside->sway, " by " + beside->columns, recording);
}

Signal<double> read_sway(const Table& table, const SwaySource& source, const RecordingOptions& options,
                         const std::function<std::vector<double>(int column)>& read, Recording& recording) {
  using Kind = SwaySource::Kind;
  const std::vector<int>& columns = source.columns;
  const std::string& where = recording.file;
  Signal<double> sway{com_sway, table.name(columns.front()), {}};
  if (source.kind == Kind::angle) {
    if (options.metres_per_unit)
      throw Error(
          Code::setting_missing, where,
          setting("unit") + " " + length_name(*options.metres_per_unit) + " declares " + sway.column + " a length",
          "give " + setting("unit") +
              " deg or rad if it is an angle, or the height of the centre of mass above the ankles as " +
              setting("com_height"));
    sway.rad = read_angles(table, columns[0], options, read, recording);
    return sway;
  }
  if (source.kind == Kind::segments) {
    sway.column += ", " + table.name(columns[1]);
    sway.rad = join_segments(read_angles(table, columns[0], options, read, recording),
                             read_angles(table, columns[1], options, read, recording), recording);
    return sway;
  }
  std::vector<std::vector<double>> positions;
  for (const int column : columns) positions.push_back(read_metres(table, column, options, read, recording));
  const std::size_t markers = positions.size() - (options.ankle_column.empty() ? 0 : 1);
  for (std::size_t marker = 0; marker < markers; ++marker) {
    if (marker > 0) sway.column += ", " + table.name(columns[marker]);
    if (options.ankle_column.empty()) {
      subtract_mean(positions[marker]);
    } else {
      for (std::size_t k = 0; k < positions[marker].size(); ++k) positions[marker][k] -= positions.back()[k];
    }
  }
  if (options.ankle_column.empty())
    add_info(recording.warnings, "mean_is_upright",
             "the ankle's position is unknown (" + setting("ankle") + "): decid assumes that the mean of " +
                 sway.column + " is upright");
  if (source.kind == Kind::displacement) {
    sway.rad = angles(positions[0], *options.com_height_m, sway.column, recording);
    return sway;
  }
  if (stddev(positions[1]) < stddev(positions[0]))
    add_caution(recording.warnings, "shoulder_moves_less",
                "the shoulder " + table.name(columns[1]) + " moves less than the hip " + table.name(columns[0]) +
                    ": check whether the two are swapped");
  const sim::Segments segments = sim::make_segments({.height_m = *options.body_height_m});
  const std::vector<double> between = difference(positions[1], positions[0]);
  sway.rad = join_segments(angles(positions[0], segments.leg_length_m, "the hip", recording),
                           angles(between, segments.trunk_length_m, "the shoulder", recording), recording);
  return sway;
}

}  // namespace decid::recording
