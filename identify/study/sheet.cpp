// A study's sheet: see sheet.hpp.
#include "identify/study/sheet.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <string_view>

#include "base/text.hpp"
#include "identify/study/detail/spreadsheet.hpp"
#include "identify/study/detail/text_key.hpp"
#include "identify/study/reading_option.hpp"
#include "identify/study/sidecar.hpp"

namespace decid {
namespace {

/// The meaning of a column: a cell of the entry, a value of decid's, or an option of reading.
enum class Role { carried, participant, session, group, condition, file, mass, height, protocol, reading };

struct Column {
  Role role;
  double per_unit = 1.0;    ///< kg of a weight, or metres of a height, in one unit; a height in "1" is in m or cm
  std::string option = {};  ///< of reading
  bool has_unit = false;    ///< a weight or a height with a unit in its name
};

struct KnownName {
  std::string_view name;
  Role role;
};

/// English and German, as laboratories name the columns of their sheets. A unit may follow a weight or a height.
constexpr auto known_names = std::to_array<KnownName>({
    {"id", Role::participant},
    {"participant", Role::participant},
    {"participant_id", Role::participant},
    {"subject", Role::participant},
    {"subject_id", Role::participant},
    {"sub_id", Role::participant},
    {"person", Role::participant},
    {"person_id", Role::participant},
    {"patient", Role::participant},
    {"patient_id", Role::participant},
    {"proband", Role::participant},
    {"proband_id", Role::participant},
    {"session", Role::session},
    {"session_id", Role::session},
    {"sitzung", Role::session},
    {"group", Role::group},
    {"gruppe", Role::group},
    {"condition", Role::condition},
    {"bedingung", Role::condition},
    {"file", Role::file},
    {"filename", Role::file},
    {"path", Role::file},
    {"recording", Role::file},
    {"datei", Role::file},
    {"dateiname", Role::file},
    {"aufnahme", Role::file},
    {"mass", Role::mass},
    {"body_mass", Role::mass},
    {"weight", Role::mass},
    {"body_weight", Role::mass},
    {"masse", Role::mass},
    {"gewicht", Role::mass},
    {"k\u00f6rpergewicht", Role::mass},
    {"koerpergewicht", Role::mass},
    {"height", Role::height},
    {"body_height", Role::height},
    {"gr\u00f6\u00dfe", Role::height},
    {"groesse", Role::height},
    {"k\u00f6rpergr\u00f6\u00dfe", Role::height},
    {"koerpergroesse", Role::height},
    {"protocol", Role::protocol},
    {"protokoll", Role::protocol},
});

struct KnownUnit {
  Role role;
  std::string_view unit;
  double size;  ///< in kg or m; 0: not read
};

/// A column in a unit that is not read is an error: carried along as any other column it would leave the body assumed.
/// "lbav" and "ini" are UCUM's [lb_av] and [in_i].
constexpr auto known_units = std::to_array<KnownUnit>({
    {Role::mass, "kg", 1.0},
    {Role::mass, "kgs", 1.0},
    {Role::mass, "kilogram", 1.0},
    {Role::mass, "kilograms", 1.0},
    {Role::mass, "lb", 0.45359237},
    {Role::mass, "lbs", 0.45359237},
    {Role::mass, "lbav", 0.45359237},
    {Role::mass, "pound", 0.45359237},
    {Role::mass, "pounds", 0.45359237},
    {Role::mass, "pfund", 0.0},
    {Role::mass, "g", 0.0},
    {Role::mass, "grams", 0.0},
    {Role::mass, "n", 0.0},
    {Role::mass, "newton", 0.0},
    {Role::mass, "st", 0.0},
    {Role::mass, "stone", 0.0},
    {Role::mass, "oz", 0.0},
    {Role::height, "m", 1.0},
    {Role::height, "metre", 1.0},
    {Role::height, "metres", 1.0},
    {Role::height, "meter", 1.0},
    {Role::height, "meters", 1.0},
    {Role::height, "cm", 1.0},
    {Role::height, "centimetre", 1.0},
    {Role::height, "centimetres", 1.0},
    {Role::height, "centimeter", 1.0},
    {Role::height, "centimeters", 1.0},
    {Role::height, "mm", 0.001},
    {Role::height, "in", 0.0254},
    {Role::height, "inch", 0.0254},
    {Role::height, "inches", 0.0254},
    {Role::height, "ini", 0.0254},
    {Role::height, "zoll", 0.0254},
    {Role::height, "ft", 0.0},
    {Role::height, "foot", 0.0},
    {Role::height, "feet", 0.0},
    {Role::height, "ftin", 0.0},
});

Column column_of(const std::string& name) {
  const std::string key = column_key(name);
  for (const KnownName& known : known_names) {
    const std::string begin = column_key(known.name);
    if (key == begin) return {known.role};
    for (const KnownUnit& unit : known_units)
      if (unit.role == known.role &&
          (key == begin + std::string(unit.unit) || key == begin + "in" + std::string(unit.unit)))
        return {known.role, unit.size, {}, true};
  }
  std::string option = find_reading_option(name);
  return option.empty() ? Column{Role::carried} : Column{Role::reading, 1.0, std::move(option)};
}

/// Gives a weight or a height without a unit in its name the unit of the sheet's sidecar.
void set_sidecar_unit(const std::string& unit, Column& column) {
  if (column.has_unit || (column.role != Role::mass && column.role != Role::height)) return;
  const std::string key = column_key(unit);
  const auto found = std::ranges::find_if(
      known_units, [&](const KnownUnit& known) { return known.role == column.role && known.unit == key; });
  column.per_unit = found == known_units.end() ? 0.0 : found->size;
}

double mass_of(const std::string& cell, double kg_per_unit, const std::string& where) {
  const std::optional<double> given = read_number(cell);
  const double kg = given.value_or(0.0) * kg_per_unit;
  if (kg < 1.0 || kg > 250.0)
    throw Error(Code::value_invalid, where, "'" + cell + "' is not a weight from 1 to 250 kg",
                kg_per_unit == 1.0 ? "give it in kg, or n/a; name a column of pounds weight_lb"
                                   : "give it in the column's unit, or n/a");
  return kg;
}

double height_of(const std::string& cell, double metres_per_unit, const std::string& where) {
  const double given = read_number(cell).value_or(0.0);
  const double metres = metres_per_unit != 1.0 ? given * metres_per_unit : given >= 30.0 ? given / 100.0 : given;
  if (metres < 0.3 || metres > 3.0)
    throw Error(Code::value_invalid, where, "'" + cell + "' is neither a height from 0.3 to 3 m nor from 30 to 300 cm",
                metres_per_unit == 1.0 ? "give it in m or cm, or n/a; name a column of inches height_in"
                                       : "give it in the column's unit, or n/a");
  return metres;
}

/// where: the line; name: the column's.
void read_cell(const Column& column, const std::string& name, const std::string& cell, const std::string& where,
               SheetLine& line) {
  switch (column.role) {
    case Role::carried:
      line.entry.cells.push_back(has_no_value(cell) ? std::string() : cell);
      return;
    case Role::participant:
      line.entry.participant = has_no_value(cell) ? std::string() : cell;
      return;
    default:
      break;
  }
  if (has_no_value(cell)) return;
  switch (column.role) {
    case Role::session:
      line.entry.session = cell;
      break;
    case Role::group:
      line.entry.group = cell;
      break;
    case Role::condition:
      line.entry.condition = cell;
      break;
    case Role::file:
      line.file = cell;
      break;
    case Role::mass:
      line.mass_kg = mass_of(cell, column.per_unit, where + ", " + name);
      break;
    case Role::height:
      line.height_m = height_of(cell, column.per_unit, where + ", " + name);
      break;
    case Role::protocol:
      line.protocol = cell;
      break;
    default: {
      ReadOptions unused;
      set_reading_option(unused, column.option, cell, where);  // throws for a wrong value
      line.reading.emplace_back(column.option, cell);
    }
  }
}

SheetLine read_line(const std::vector<Column>& columns, const std::vector<std::string>& names,
                    const std::vector<std::string>& cells, std::size_t number, const std::string& where) {
  SheetLine line;
  line.number = number;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    try {
      read_cell(columns[i], names[i], i < cells.size() ? cells[i] : std::string(), where, line);
    } catch (const Error& error) {
      if (!line.error) line.error = error;
    }
  }
  const auto beyond = cells.begin() + static_cast<std::ptrdiff_t>(std::min(cells.size(), columns.size()));
  if (!line.error && std::any_of(beyond, cells.end(), [](const std::string& cell) { return !cell.empty(); }))
    line.error = Error(Code::value_invalid, where,
                       format("has %zu cells, and the first line %zu names", cells.size(), columns.size()),
                       "delete the others; decimal commas need quotes, or semicolons or tabs between cells");
  if (!line.error && line.file.empty() && line.entry.participant.empty())
    line.error =
        Error(Code::value_missing, where, "names neither a participant nor a file", "give one, or delete the line");
  return line;
}

/// Throws Error if two columns mean the same. units: of columns, by the sidecar.
std::vector<Column> read_columns(const std::vector<std::string>& names, const std::map<std::string, std::string>& units,
                                 const std::string& where) {
  std::vector<Column> columns;
  std::map<std::pair<Role, std::string>, std::string> seen;
  for (const std::string& name : names) {
    Column& column = columns.emplace_back(column_of(name));
    const auto unit = units.find(name);
    if (unit != units.end()) set_sidecar_unit(unit->second, column);
    if (column.per_unit == 0.0)
      throw Error(Code::unit_unknown, where,
                  "\"" + name + "\" is a weight or a height in another unit" +
                      (column.has_unit ? "" : ", \"" + unit->second + "\" by the sidecar"),
                  "give weight in kg or lb, height in m, cm, mm or inches: weight_kg, weight_lb, height_m, height_in");
    const std::string carried_as = column.role == Role::carried ? text_key(name) : column.option;
    const auto [first, is_new] = seen.try_emplace({column.role, carried_as}, name);
    if (!is_new)
      throw Error(Code::column_ambiguous, where,
                  "has two columns of one meaning, \"" + first->second + "\" and \"" + name + "\"",
                  "rename or delete one of them");
  }
  const auto has = [&](Role role) { return std::ranges::find(columns, role, &Column::role) != columns.end(); };
  if (!has(Role::participant) && !has(Role::file))
    throw Error(Code::column_missing, where, "has neither a column \"participant_id\" nor a column \"file\"",
                "name the columns in the first line, between tabs, commas or semicolons");
  return columns;
}

}  // namespace

std::string StudySheet::locate(const SheetLine& line) const {
  return format("%s, line %zu", file.string().c_str(), line.number);
}

std::function<std::string(const SheetEntry& entry)> StudySheet::reader_for(const std::string& column) const {
  switch (column_of(column).role) {
    case Role::participant:
      return &SheetEntry::participant;
    case Role::session:
      return &SheetEntry::session;
    case Role::group:
      return &SheetEntry::group;
    case Role::condition:
      return &SheetEntry::condition;
    default:
      break;
  }
  const auto found = std::ranges::find(columns, column_key(column), column_key);
  if (found == columns.end())
    throw Error(Code::column_missing, file.string(), "has no column '" + column + "' of participants or conditions",
                "name participant_id, session, group, condition or another column of the sheet");
  return [place = static_cast<std::size_t>(found - columns.begin())](const SheetEntry& entry) {
    return place < entry.cells.size() ? entry.cells[place] : std::string();
  };
}

bool names_participants(const std::string& column) {
  return column_of(column).role == Role::participant;
}

bool names_groups(const std::string& column) {
  return column_of(column).role == Role::group;
}

bool names_weights(const std::string& column) {
  return column_of(column).role == Role::mass;
}

bool names_heights(const std::string& column) {
  return column_of(column).role == Role::height;
}

bool names_ages(const std::string& column) {
  constexpr auto known =
      std::to_array<std::string_view>({"age", "age_years", "age_in_years", "alter", "alter_jahre", "alter_in_jahren"});
  return std::ranges::any_of(known,
                             [key = column_key(column)](std::string_view name) { return column_key(name) == key; });
}

bool has_no_value(const std::string& cell) {
  const std::string key = text_key(cell);
  return key.empty() || key == "n/a" || key == "na" || key == "nan" || key == "#n/a";
}

std::optional<double> read_number(std::string cell) {
  std::ranges::replace(cell, ',', '.');
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value)) return {};
  return value;
}

StudySheet read_sheet(const std::filesystem::path& path) {
  std::vector<std::vector<std::string>> rows = read_spreadsheet(path);
  std::vector<std::string>& names = rows.front();
  while (!names.empty() && names.back().empty()) names.pop_back();
  const std::vector<Column> columns = read_columns(names, sidecar_units(path), path.string() + ", line 1");
  StudySheet sheet{path, {}, {}, names};
  for (std::size_t i = 0; i < columns.size(); ++i)
    if (columns[i].role == Role::carried) sheet.columns.push_back(names[i]);
  for (std::size_t row = 1; row < rows.size(); ++row) {
    if (std::ranges::all_of(rows[row], [](const std::string& cell) { return cell.empty(); })) continue;
    const std::string where = format("%s, line %zu", path.string().c_str(), row + 1);
    sheet.lines.push_back(read_line(columns, names, rows[row], row + 1, where));
  }
  if (sheet.lines.empty())
    throw Error(Code::file_empty, path.string(), "has no line below its names", "add a line per recording or person");
  return sheet;
}

SheetLine merged(SheetLine recording, const SheetLine& participant) {
  const auto fill = [](std::string& empty, const std::string& from) {
    if (empty.empty()) empty = from;
  };
  fill(recording.entry.participant, participant.entry.participant);
  fill(recording.entry.session, participant.entry.session);
  fill(recording.entry.group, participant.entry.group);
  fill(recording.entry.condition, participant.entry.condition);
  fill(recording.protocol, participant.protocol);
  for (std::size_t i = 0; i < recording.entry.cells.size(); ++i)
    fill(recording.entry.cells[i], participant.entry.cells.at(i));
  if (!recording.mass_kg) recording.mass_kg = participant.mass_kg;
  if (!recording.height_m) recording.height_m = participant.height_m;
  for (const auto& option : participant.reading)
    if (std::ranges::find(recording.reading, option.first, &std::pair<std::string, std::string>::first) ==
        recording.reading.end())
      recording.reading.push_back(option);
  if (!recording.error) recording.error = participant.error;
  return recording;
}

}  // namespace decid
