// Sources of the sway: see sway_source.hpp.
#include "recording/detail/sway_source.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/math/statistics.hpp"
#include "base/setting.hpp"
#include "recording/quality/detail/block_means.hpp"
#include "recording/table/columns.hpp"
#include "recording/table/detail/candidates.hpp"
#include "recording/table/detail/trials.hpp"
#include "sim/double_pendulum.hpp"
#include "sim/segments.hpp"

namespace decid::recording {

namespace {

const std::string& full_name(const Table& table, int column) {
  return table.names()[static_cast<std::size_t>(column)];
}

/// Returns true if the name has one of the words, also after the letter of a side: "lankle", "RKNEE".
bool has_word(std::string_view name, std::initializer_list<std::string_view> list) {
  return std::ranges::any_of(words_in(name), [&](std::string_view word) {
    const bool may_have_side = word.size() > 3 && (word.front() == 'l' || word.front() == 'r');
    return one_of(word, list) || (may_have_side && one_of(word.substr(1), list));
  });
}

/// Throws Error for a frequency response, whose table has lines of frequencies instead of samples.
void refuse_response(const Table& table, const std::string& where) {
  const auto has = [&](std::string_view part) {
    return std::ranges::any_of(table.names(), [&](const std::string& name) { return words(name).front() == part; });
  };
  if (has("frequency") && has("gain"))
    throw Error(Code::file_unsupported, where, "is a frequency response, not a recording",
                "fit it with " + setting("frf") + " " + where);
}

void refuse_ankle(const std::string& name, const std::string& where) {
  if (other_quantity(name) != nullptr) return;              // another error names that quantity
  for (const char* whole : {"com", "cog", "sway", "body"})  // such as "com_sway about the ankle", "CoMAnkleAngle"
    if (words(name).front().starts_with(whole)) return;
  if (!has_word(name, {"ankle", "sprunggelenk", "sprunggelenkswinkel", "sprunggelenkwinkel", "osg", "dorsiflexion",
                       "plantarflexion"}))
    return;
  throw Error(Code::column_unsuitable, where,
              name + " is an ankle angle by its name: relative to the platform, not in space",
              "add the platform's tilt, and name the sum sway");
}

/// Words of names and labels of markers (Plug-in Gait's among them), with the part of the body. Vertebrae between T10
/// and the sacrum are missing: they are near the centre of mass.
struct PartWord {
  std::string_view word;
  const char* part;
};
constexpr PartWord part_words[] = {
    {"head", "head"},         {"kopf", "head"},       {"fhd", "head"},          {"bhd", "head"},
    {"neck", "neck"},         {"nacken", "neck"},     {"c7", "neck"},           {"shoulder", "shoulder"},
    {"schulter", "shoulder"}, {"sho", "shoulder"},    {"acromion", "shoulder"}, {"akromion", "shoulder"},
    {"acr", "shoulder"},      {"trunk", "trunk"},     {"rumpf", "trunk"},       {"thorax", "trunk"},
    {"chest", "trunk"},       {"brust", "trunk"},     {"sternum", "trunk"},     {"strn", "trunk"},
    {"clavicle", "trunk"},    {"clavicula", "trunk"}, {"clav", "trunk"},        {"scapula", "trunk"},
    {"spine", "spine"},       {"t8", "spine"},        {"t10", "spine"},         {"th10", "spine"},
    {"foot", "foot"},         {"fuss", "foot"},       {"fu\xC3\x9F", "foot"},   {"knee", "knee"},
    {"knie", "knee"},         {"thigh", "thigh"},     {"pelvis", "pelvis"},     {"hip", "hip"},
};

/// Warns of a name of a body part or another direction: the model sways as a whole, about the ankles, in one direction.
void warn_of_part(const std::string& name, Recording& recording) {
  std::string_view warned;
  for (const auto& [word, part] : part_words) {
    // A hip marker may stand for the centre of mass, a hip joint's angle may not.
    if (part == warned || !has_word(name, {word}) || (word == "hip" && !has_word(name, {"angle", "angles", "flexion"})))
      continue;
    add_caution(
        recording.warnings, "sway_of_a_part",
        name + " belongs to the " + part + " by its name; the model needs the sway of the body's centre of mass");
    warned = part;
  }
  for (const char* other : {"ml", "lateral", "mediolateral", "yaw", "heading", "gaze", "eye", "target", "setpoint"})
    if (has_word(name, {other}))
      add_caution(recording.warnings, "not_this_sway",
                  name + " is '" + other + "' by its name; the model needs the forward sway");
}

/// Returns true for "COM_x", "C7 X", "Tx", "com_position", "COM displacement", and false for "sway_x" and "Trunk Angle
/// X".
bool is_position_name(const std::string& name) {
  if (has_word(name, {"angle", "angles", "angular", "winkel", "rotation", "rot", "orientation", "euler", "pitch",
                      "roll", "yaw", "tilt", "lean", "inclination", "neigung", "flexion"}))
    return false;
  if (has_word(name, {"displacement", "displacements", "position", "positions", "pos", "trajectory", "comx", "comy",
                      "comz", "cogx", "cogy", "cogz", "tx", "ty", "tz"}))  // NDI's tools
    return true;
  const std::vector<std::string> parts = words(name);
  if (parts.front() == "sway" || parts.front() == "body") return false;
  const bool is_centre = one_of(parts.front(), {"com", "cog"});
  return std::any_of(parts.begin() + 1, parts.end(), [&](const std::string& part) {
    return one_of(part, {"x", "y", "z"}) || (is_centre && one_of(part, {"ap", "ml"}));
  });
}

/// Throws Error if every candidate is a quantity by its name that is neither an angle nor a length.
void refuse_other_quantities(const Table& table, const std::vector<int>& candidates, const std::string& where) {
  std::string list;
  for (const int column : candidates) {
    const std::string& name = full_name(table, column);
    const char* quantity = other_quantity(name);
    if (!table.has_header() || quantity == nullptr || find_metres_per_unit(name)) return;
    if (list.size() < 200) list += (list.empty() ? "'" : ", '") + name + "' is " + quantity;
  }
  throw Error(
      Code::column_unsuitable, where, "has no column of angles by the names: " + list,
      "convert the sway to degrees, or name its column with " + setting("column") + " and give " + setting("unit"));
}

/// Includes displacements: they may be the only column, and their unit is checked later.
int find_sway(const Table& table, int time, const RecordingOptions& options, Recording& recording) {
  const int named = find_named(table, time,
                               {"com_sway",
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
                                "k\xC3\xB6rperneigung"},
                               recording.file, setting("column"));
  if (named >= 0) return named;
  std::vector<int> candidates = sway_candidates(table, time);
  const std::string unread = table.unread().empty() ? std::string() : "; not read: " + table.unread();
  const std::string add = unread.empty()
                              ? "add the sway, or name it with " + setting("column")
                              : "save the sway as a vector of real numbers, or name it with " + setting("column");
  if (candidates.empty())
    throw Error(Code::column_missing, recording.file, "has a time column but no sway column" + unread, add);
  const int tilt = find_tilt_column(table, time, recording.file, setting("column"));
  std::erase(candidates, tilt);
  if (!options.trial_column.empty())
    for (const int column : trial_columns(table, options.trial_column, recording.file)) std::erase(candidates, column);
  if (candidates.size() > 1) refuse_other_quantities(table, candidates, recording.file);
  if (candidates.size() > 1) {
    // "0,01,0,02": half as many names as cells, so they are not a header.
    const bool decimal_commas = !table.has_header() && table.columns() % 2 == 0 && table.arrays().empty();
    std::string list;
    for (const int column : candidates)
      list += list.size() > 200 ? "" : (list.empty() ? "'" : ", '") + full_name(table, column) + "'";
    throw Error(
        Code::column_ambiguous, recording.file, "has several columns that may be the sway: " + list,
        std::string("name one with " + setting("column") + ", or the sway's parts with " + setting("leg") + " and " +
                    setting("trunk") + ", or " + setting("hip") + " and " + setting("shoulder")) +
            (decimal_commas ? "; if its numbers have decimal commas, save it with semicolons between them" : "") +
            trial_advice(table));
  }
  if (candidates.empty() && tilt < 0)
    throw Error(Code::column_missing, recording.file,
                "has no sway column except '" + options.trial_column + "' of " + setting("trial_column") + unread, add);
  if (candidates.empty())
    throw Error(Code::column_missing, recording.file,
                "has a column of the platform's tilt, '" + full_name(table, tilt) + "', but no sway column" + unread,
                add);
  const int sway = candidates.front();
  if (table.has_header()) {
    add_info(recording.warnings, "column_assumed",
             "column '" + full_name(table, sway) + "' is assumed to be the sway: it is the only candidate" +
                 (tilt >= 0 ? " except the platform's tilt" : ""));
  }
  return sway;
}

/// Returns a column of lengths in metres.
std::vector<double> read_metres(const Table& table, int column, const RecordingOptions& options,
                                const std::function<std::vector<double>(int)>& read, const std::string& where) {
  const std::string& name = full_name(table, column);
  const std::optional<double> metres = options.metres_per_unit ? options.metres_per_unit : find_metres_per_unit(name);
  if (!metres)
    throw Error(Code::unit_unknown, where, "the name of " + name + " has no unit",
                "give " + setting("unit") + " mm, cm or m");
  std::vector<double> values = read(column);
  for (double& value : values) value *= *metres;
  return values;
}

void subtract_mean(std::vector<double>& values) {
  const double middle = mean(values);
  for (double& value : values) value -= middle;
}

/// Returns the angles of displacements at the top of a rod of this length.
std::vector<double> angles(const std::vector<double>& displacement_m, double length_m, const std::string& what,
                           const std::string& where) {
  std::vector<double> result;
  result.reserve(displacement_m.size());
  for (const double x : displacement_m) {
    if (!(std::abs(x) < length_m))
      throw Error(
          Code::value_invalid, where,
          what + " is " + three_digits(x) + " m from the upright, at a height of " + three_digits(length_m) + " m",
          "check units and columns; positions count from the ankle (" + setting("ankle") + " COLUMN)");
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

/// Returns the standard deviation of block means about their line: without a sensor's noise, offset and drift.
double slow_deviation(const std::vector<double>& values) {
  constexpr std::size_t blocks = 240;
  std::vector<double> means = block_means(values, std::max<std::size_t>(1, values.size() / blocks));
  std::erase_if(means, [](double value) { return std::isnan(value); });
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

/// Returns the sway of both segments. Warns if the hip moves, because the model is one segment.
std::vector<double> join_segments(const std::vector<double>& leg, const std::vector<double>& trunk,
                                  Recording& recording) {
  constexpr double max_ratio = 0.2;
  std::vector<double> sway = sway_of(leg, trunk), hip(leg.size());
  for (std::size_t k = 0; k < hip.size(); ++k) hip[k] = trunk[k] - leg[k];
  const double of_hip = slow_deviation(hip), of_sway = slow_deviation(sway);
  if (of_hip > max_ratio * of_sway)
    add_caution(recording.warnings, "hip_moves",
                "the hip angle varies by " + three_digits(of_hip / sim::rad_per_deg) + " degrees rms, the sway by " +
                    three_digits(of_sway / sim::rad_per_deg) +
                    ": the model is one segment, so these values are biased, most of all stiffness and delay");
  return sway;
}

/// Removes steps of about 360 degrees, which programs cause that keep angles within one turn.
void unwrap(std::vector<double>& rad, const std::string& name, Recording& recording) {
  constexpr double turn = 360.0 * sim::rad_per_deg, margin = 60.0 * sim::rad_per_deg;
  double turns = 0.0, sum = 0.0;
  bool any = false;
  for (std::size_t k = 0; k < rad.size(); ++k) {
    const double step = k > 0 ? rad[k] + turns * turn - rad[k - 1] : 0.0;
    if (std::abs(std::abs(step) - turn) < margin) {
      turns += step > 0.0 ? -1.0 : 1.0;
      any = true;
    }
    if (turns != 0.0) rad[k] += turns * turn;  // keeps -0
    sum += rad[k];
  }
  if (!any) return;
  const double whole = turn * std::round(sum / static_cast<double>(rad.size()) / turn);
  for (double& value : rad) value -= whole;
  add_info(recording.warnings, "unwrapped", name + " jumps by 360 degrees: decid removed whole turns");
}

/// Returns angles of leg or trunk, rad.
std::vector<double> read_angles(const Table& table, int column, const RecordingOptions& options,
                                const std::function<std::vector<double>(int)>& read, Recording& recording) {
  const std::string& name = full_name(table, column);
  const double unit_rad = rad_in(angle_unit(table, column, options.unit, setting("unit"), recording));
  if (!options.unit && !unit_in(name) && !table.unit() && is_position_name(name))
    add_caution(recording.warnings, "perhaps_a_length",
                name + " is a position by its name; decid reads it in degrees: if it is a length, give " +
                    setting("com_height") + " and " + setting("unit") + " mm, cm or m; if not, " + setting("unit") +
                    " deg");
  std::vector<double> values = read(column);
  for (double& value : values) value *= unit_rad;
  unwrap(values, name, recording);
  return values;
}

/// Returns the mean square about the mean.
double mean_square(const std::vector<double>& values) {
  double sum = 0.0, squares = 0.0;
  for (const double value : values) sum += value;
  const double mean = sum / static_cast<double>(values.size());
  for (const double value : values) squares += (value - mean) * (value - mean);
  return squares / static_cast<double>(values.size());
}

/// Returns the axis at the end of a name, apart from units: 'x' for "HIP_X (mm)", "hip.x" and "Hip X"; 0: none.
char axis_of(const std::string& name) {
  std::vector<std::string> words(1);
  for (const char c : name) {
    if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'))
      words.back() += c;
    else if (c >= 'A' && c <= 'Z')
      words.back() += static_cast<char>(c - 'A' + 'a');
    else if (!words.back().empty())
      words.emplace_back();
  }
  while (!words.empty() &&
         (words.back().empty() || words.back() == "mm" || words.back() == "cm" || words.back() == "m"))
    words.pop_back();
  const bool is_axis = words.size() > 1 && (words.back() == "x" || words.back() == "y" || words.back() == "z");
  return is_axis ? words.back().front() : '\0';
}

void refuse_same_column(const Table& table, const std::vector<int>& columns, const std::string& where) {
  for (std::size_t i = 0; i < columns.size(); ++i)
    if (std::find(columns.begin(), columns.begin() + static_cast<std::ptrdiff_t>(i), columns[i]) !=
        columns.begin() + static_cast<std::ptrdiff_t>(i))
      throw Error(Code::setting_conflict, where, "'" + full_name(table, columns[i]) + "' is named for two signals",
                  "name a column for each");
}

void warn_of_axes(const Table& table, const std::vector<int>& columns, Recording& recording) {
  const std::string& first = full_name(table, columns.front());
  for (const int column : columns) {
    const std::string& name = full_name(table, column);
    const char axis = axis_of(first), other = axis_of(name);
    if (axis == '\0' || other == '\0' || axis == other) continue;
    add_caution(recording.warnings, "axes_differ",
                first + " and " + name + " have different axes: name columns in the direction of the tilt");
    return;
  }
}

}  // namespace

SwaySource find_sway_source(const Table& table, int time, const RecordingOptions& options, Recording& recording) {
  using Kind = SwaySource::Kind;
  const std::string& where = recording.file;
  const bool segments = !options.leg_column.empty() || !options.trunk_column.empty();
  const bool markers = !options.hip_column.empty() || !options.shoulder_column.empty();
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
  if (options.com_height_m && !(*options.com_height_m > 0.0 && std::isfinite(*options.com_height_m)))
    throw Error(Code::setting_out_of_range, setting("com_height"), "is " + three_digits(*options.com_height_m) + " m",
                "give metres above the ankles");
  // Without hip and shoulder the height is the person's, which programs give for every recording.
  if (options.body_height_m && !(*options.body_height_m > 0.0 && std::isfinite(*options.body_height_m)))
    throw Error(Code::setting_out_of_range, setting("height"), "is " + three_digits(*options.body_height_m) + " m",
                "give the person's height in metres");
  SwaySource source;
  const auto add = [&](const std::string& column, const std::string& setting_name) {
    source.columns.push_back(named_column(table, column, where, setting_name));
  };
  if (segments) {
    source.kind = Kind::segments;
    add(options.leg_column, setting("leg"));
    add(options.trunk_column, setting("trunk"));
  } else if (markers) {
    source.kind = Kind::markers;
    add(options.hip_column, setting("hip"));
    add(options.shoulder_column, setting("shoulder"));
  } else {
    source.kind = options.com_height_m ? Kind::displacement : Kind::angle;
    if (options.column.empty()) {
      refuse_response(table, where);
      source.columns.push_back(find_sway(table, time, options, recording));
    } else {
      add(options.column, setting("column"));
    }
    const std::string& name = full_name(table, source.columns.front());
    if (!options.com_height_m) refuse_ankle(name, where);
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
                full_name(table, first) + " has " + std::to_string(table.rows(first)) + " values, " +
                    full_name(table, column) + " " + std::to_string(table.rows(column)),
                "name signals of equal length");
  }
  return source;
}

Signal<double> read_sway(const Table& table, const SwaySource& source, const RecordingOptions& options,
                         const std::function<std::vector<double>(int column)>& read, Recording& recording) {
  using Kind = SwaySource::Kind;
  const std::vector<int>& columns = source.columns;
  const std::string& where = recording.file;
  Signal<double> sway{com_sway, full_name(table, columns.front()), {}};
  if (source.kind == Kind::angle) {
    if (options.metres_per_unit)
      throw Error(Code::setting_missing, where, sway.column + " was declared a length",
                  "give the height of the centre of mass above the "
                  "ankles as " +
                      setting("com_height"));
    sway.rad = read_angles(table, columns[0], options, read, recording);
    return sway;
  }
  if (source.kind == Kind::segments) {
    sway.column += ", " + full_name(table, columns[1]);
    sway.rad = join_segments(read_angles(table, columns[0], options, read, recording),
                             read_angles(table, columns[1], options, read, recording), recording);
    return sway;
  }
  std::vector<std::vector<double>> positions;
  for (const int column : columns) positions.push_back(read_metres(table, column, options, read, where));
  const std::size_t markers = positions.size() - (options.ankle_column.empty() ? 0 : 1);
  for (std::size_t marker = 0; marker < markers; ++marker) {
    if (marker > 0) sway.column += ", " + full_name(table, columns[marker]);
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
    sway.rad = angles(positions[0], *options.com_height_m, sway.column, where);
    return sway;
  }
  if (mean_square(positions[1]) < mean_square(positions[0]))
    add_caution(recording.warnings, "shoulder_moves_less",
                "the shoulder " + full_name(table, columns[1]) + " moves less than the hip " +
                    full_name(table, columns[0]) + ": check whether the two are swapped");
  const sim::Segments segments = sim::make_segments({.height_m = *options.body_height_m});
  std::vector<double> between(positions[0].size());
  for (std::size_t k = 0; k < between.size(); ++k) between[k] = positions[1][k] - positions[0][k];
  sway.rad = join_segments(angles(positions[0], segments.leg_length_m, "the hip", where),
                           angles(between, segments.trunk_length_m, "the shoulder", where), recording);
  return sway;
}

}  // namespace decid::recording
