// A study's sheet: see sheet.hpp.
#include "identify/study/sheet.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <set>
#include <string_view>

#include "base/setting.hpp"
#include "base/text.hpp"
#include "identify/study/detail/sheet_columns.hpp"
#include "identify/study/detail/spreadsheet.hpp"
#include "identify/study/detail/text_key.hpp"
#include "identify/study/reading_option.hpp"
#include "identify/study/sidecar.hpp"
#include "recording/table/columns.hpp"

namespace decid {
namespace {

/// Returns true for a cell without a person, a session or a group, also by a mark for none.
bool is_none(const std::string& cell) {
  constexpr auto marks = std::to_array<std::string_view>({"-", "--", ".", "\u2013", "\u2014"});
  return has_no_value(cell) || std::ranges::find(marks, cell) != marks.end();
}

/// A number of a cell, and its unit in kg or m; cm are 0.01 m already.
struct BodyCell {
  double value = 0.0, per_unit = 1.0;
  bool has_unit = false;  ///< of its own
};

constexpr const char* letters_of_units = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";

/// Returns true for a cell in another unit than kg, m and cm, also in one that is not read: "154 lb", "5 ft 9".
bool has_other_unit(ColumnRole role, const std::string& cell) {
  const std::size_t first = cell.find_first_of("0123456789");
  const std::size_t end = cell.find_first_not_of("0123456789.,", first);
  if (first == std::string::npos || end == std::string::npos) return false;
  const std::string rest = cell.substr(end);
  constexpr auto marks = std::to_array<std::string_view>({"'", "\"", "\u2032", "\u2033", "\u2019", "\u201D", "\u00B4"});
  if (role == ColumnRole::height &&
      std::ranges::any_of(marks, [&](std::string_view mark) { return rest.starts_with(mark); }))
    return true;  // feet or inches
  const std::size_t begin = std::min(rest.find_first_not_of(" ([."), rest.size());
  const std::size_t word_end = std::min(rest.find_first_not_of(letters_of_units, begin), rest.size());
  const std::optional<double> unit = body_unit(role, rest.substr(begin, word_end - begin));
  return unit && *unit != 1.0 && *unit != centimetre;
}

/// Reads "70", "70 kg" or "154lb"; the value 0 for a cell that is no such number. Throws Error if the units of cell and
/// column differ, and for a cell without a unit if another cell of the column is not in kg, m or cm.
BodyCell read_body_cell(const SheetColumn& column, const std::string& cell, const std::string& where) {
  if (const std::optional<double> number = read_number(cell)) {
    if (!column.other_unit.empty())
      throw Error(Code::value_invalid, where, "'" + cell + "' has no unit, and " + column.other_unit + " has one",
                  "give one unit, in the name or in all cells");
    return {*number, column.per_unit};
  }
  const std::size_t end = cell.find_last_of("0123456789");
  if (end == std::string::npos) return {};
  const std::string text = cell.substr(end + 1);
  const std::optional<double> number = read_number(cell.substr(0, end + 1));
  const std::optional<double> unit = body_unit(column.role, text);
  const bool is_plain = text.find_first_not_of(std::string(letters_of_units) + " .()[]") == std::string::npos;
  if (!number || !unit || *unit == 0.0 || !is_plain) return {};
  const double per_unit = *unit == centimetre ? 1.0 : *unit;
  if (column.has_unit && per_unit != column.per_unit)
    throw Error(Code::value_invalid, where, "'" + cell + "' has another unit than the column's name",
                "give one unit, in the name or in the cells");
  return {*unit == centimetre ? *number / 100.0 : *number, per_unit, true};
}

double mass_of(const SheetColumn& column, const std::string& cell, const std::string& where) {
  const BodyCell given = read_body_cell(column, cell, where);
  const double kg = given.value * given.per_unit;
  if (kg < 1.0 || kg > 250.0)
    throw Error(Code::value_invalid, where, "'" + cell + "' is not a weight from 1 to 250 kg",
                column.per_unit == 1.0 ? "give it in kg, or n/a; name a column of pounds weight_lb"
                                       : "give it in the column's unit, or n/a");
  return kg;
}

double height_of(const SheetColumn& column, const std::string& cell, const std::string& where) {
  const BodyCell given = read_body_cell(column, cell, where);
  const bool is_in_m_or_cm = !given.has_unit && given.per_unit == 1.0;
  const double metres = is_in_m_or_cm && given.value >= 30.0 ? given.value / 100.0 : given.value * given.per_unit;
  if (metres < 0.3 || metres > 3.0)
    throw Error(Code::value_invalid, where, "'" + cell + "' is neither a height from 0.3 to 3 m nor from 30 to 300 cm",
                column.per_unit == 1.0
                    ? "give it in m or cm, or n/a; name a column of inches height_in, and give feet as inches"
                    : "give it in the column's unit, or n/a");
  return metres;
}

/// where: the line; name: the column's.
void read_cell(const SheetColumn& column, const std::string& name, const std::string& cell, const std::string& where,
               SheetLine& line) {
  const bool may_be_marked =
      column.role == ColumnRole::participant || column.role == ColumnRole::session || column.role == ColumnRole::group;
  if (may_be_marked ? is_none(cell) : has_no_value(cell)) {
    if (column.role == ColumnRole::carried) line.entry.cells.emplace_back();
    return;
  }
  switch (column.role) {
    case ColumnRole::carried:
      line.entry.cells.push_back(cell);
      break;
    case ColumnRole::participant:
      line.entry.participant = cell;
      break;
    case ColumnRole::session:
      line.entry.session = without_point_zero(cell);
      break;
    case ColumnRole::group:
      line.entry.group = without_point_zero(cell);
      break;
    case ColumnRole::condition:
      line.entry.condition = without_point_zero(cell);
      break;
    case ColumnRole::file:
      line.file = cell;
      break;
    case ColumnRole::mass:
      line.mass_kg = mass_of(column, cell, where + ", " + name);
      break;
    case ColumnRole::height:
      line.height_m = height_of(column, cell, where + ", " + name);
      break;
    case ColumnRole::protocol:
      line.protocol = cell;
      break;
    default: {
      ReadOptions unused;
      set_reading_option(unused, column.option, cell, where);  // throws for a wrong value
      line.reading.emplace_back(column.option, cell);
    }
  }
}

SheetLine read_line(const std::vector<SheetColumn>& columns, const std::vector<std::string>& names,
                    const std::vector<std::string>& cells, std::size_t number, const std::string& where) {
  SheetLine line;
  line.number = number;
  line.cells = cells.size();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    try {
      read_cell(columns[i], names[i], i < cells.size() ? cells[i] : std::string(), where, line);
    } catch (const Error& error) {
      if (!line.error) line.error = error;
    }
  }
  const auto beyond = cells.begin() + static_cast<std::ptrdiff_t>(std::min(cells.size(), columns.size()));
  if (std::any_of(beyond, cells.end(), [](const std::string& cell) { return !cell.empty(); }))
    line.misfit = Error(Code::value_invalid, where,
                        format("has %zu cells, and the first line %zu names", cells.size(), columns.size()),
                        "delete the others; decimal commas need quotes, or semicolons or tabs between cells");
  if (!line.misfit && line.file.empty() && line.entry.participant.empty())
    line.misfit =
        Error(Code::value_missing, where, "names neither a participant nor a file", "give one, or delete the line");
  if (!line.error) line.error = line.misfit;
  return line;
}

/// Throws Error for a recording that was given as a sheet: its time increases from line to line, except between trials.
void refuse_recording(const std::vector<std::vector<std::string>>& rows, const std::filesystem::path& path) {
  constexpr std::size_t min_samples = 100;
  const std::vector<std::string>& names = rows.front();
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!recording::is_time_name(names[i])) continue;
    std::size_t rises = 0;
    std::optional<double> before;
    for (std::size_t row = 1; row < rows.size(); ++row) {
      const std::optional<double> now = i < rows[row].size() ? read_number(rows[row][i]) : std::nullopt;
      if (now && before && *now > *before) ++rises;
      before = now;
    }
    if (rises >= min_samples && 10 * rises >= 9 * (rows.size() - 1))
      throw Error(Code::file_unsupported, path.string(),
                  "looks like a recording, not like a study's sheet: '" + names[i] + "' increases from line to line",
                  "name it without " + setting("study"));
  }
}

/// Throws Error if two columns mean the same. units: of columns, by the sidecar.
std::vector<SheetColumn> read_columns(const std::vector<std::string>& names,
                                      const std::map<std::string, std::string>& units, const std::string& where) {
  std::vector<SheetColumn> columns = sheet_columns(names);
  std::map<std::pair<ColumnRole, std::string>, std::string> seen;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string& name = names[i];
    SheetColumn& column = columns[i];
    const auto unit = units.find(name);
    if (unit != units.end()) set_sidecar_unit(unit->second, column);
    if (column.per_unit == 0.0)
      throw Error(Code::unit_unknown, where,
                  "\"" + name + "\" is a weight or a height in another unit" +
                      (column.has_unit ? "" : ", \"" + unit->second + "\" by the sidecar"),
                  "give weight in kg or lb, height in m, cm, mm or inches: weight_kg, weight_lb, height_m, height_in");
    const std::string carried_as = column.role == ColumnRole::carried ? text_key(name) : column.option;
    const auto [first, is_new] = seen.try_emplace({column.role, carried_as}, name);
    if (!is_new)
      throw Error(Code::column_ambiguous, where,
                  "has two columns of one meaning, \"" + first->second + "\" and \"" + name + "\"",
                  "rename or delete one of them");
  }
  const auto has = [&](ColumnRole role) {
    return std::ranges::find(columns, role, &SheetColumn::role) != columns.end();
  };
  if (!has(ColumnRole::participant) && !has(ColumnRole::file))
    throw Error(Code::column_missing, where, "has neither a column \"participant_id\" nor a column \"file\"",
                "name the columns in the first line, between tabs, commas or semicolons");
  return columns;
}

/// Finds the first cell in another unit than kg, m and cm of each weight and height whose name and sidecar have no
/// unit.
void find_other_units(const std::vector<std::vector<std::string>>& rows, std::vector<SheetColumn>& columns) {
  for (std::size_t i = 0; i < columns.size(); ++i) {
    SheetColumn& column = columns[i];
    const bool is_body = column.role == ColumnRole::mass || column.role == ColumnRole::height;
    if (!is_body || column.has_unit || column.has_sidecar_unit) continue;
    for (std::size_t row = 1; row < rows.size() && column.other_unit.empty(); ++row)
      if (i < rows[row].size() && has_other_unit(column.role, rows[row][i]))
        column.other_unit = format("'%s' in line %zu", rows[row][i].c_str(), row + 1);
  }
}

/// A column that is carried along, though its name is an option of the program, and the setting's name in sheets.
struct OptionsWord {
  std::string_view key, setting;
  bool (*is_setting)(const std::vector<std::string>& cells);  ///< cells: those with a value
};

bool has_number(const std::vector<std::string>& cells) {
  return std::ranges::any_of(cells, [](const std::string& cell) { return read_number(cell).has_value(); });
}

bool has_no_side(const std::vector<std::string>& cells) {
  constexpr auto sides =
      std::to_array<std::string_view>({"left", "right", "both", "l", "r", "b", "links", "rechts", "beide", "li", "re",
                                       "bilateral", "dominant", "nondominant", "yes", "no", "none"});
  return std::ranges::any_of(cells, [&](const std::string& cell) {
    return !read_number(cell) && std::ranges::find(sides, column_key(cell)) == sides.end();
  });
}

bool has_one_word(const std::vector<std::string>& cells) {
  return cells.size() > 1 && !read_number(cells.front()) &&
         std::ranges::all_of(cells, [&](const std::string& cell) { return cell == cells.front(); });
}

/// Returns true for a name as programs give to columns: "HIP_x", "RHIP:X", "hip2". A side, a finding and a size are
/// not.
bool is_like_column(const std::string& cell) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  const auto is_letter = [](char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); };
  const auto joins = [&](char c) { return is_digit(c) || c == '_' || c == ':'; };
  return !cell.empty() && is_letter(cell.front()) && std::ranges::any_of(cell, joins) &&
         std::ranges::all_of(cell, [&](char c) { return is_letter(c) || joins(c); });
}

bool has_column(const std::vector<std::string>& cells) {
  return std::ranges::any_of(cells, is_like_column);
}

/// Returns true if a cell is a number that is rather a mark of missing values than a count or a percentage.
bool has_mark(const std::vector<std::string>& cells) {
  return std::ranges::any_of(cells, [](const std::string& cell) {
    const double number = read_number(cell).value_or(0.0);
    return number < 0.0 || number >= 999.0;
  });
}

constexpr auto options_words =
    std::to_array<OptionsWord>({{"start", "begin is the setting", has_number},
                                {"leg", "leg_column is the setting", has_no_side},
                                {"hip", "hip_column is the setting", has_column},
                                {"shoulder", "shoulder_column is the setting", has_column},
                                {"ankle", "ankle_column is the setting", has_column},
                                {"missing", "missing_value is the setting", has_mark},
                                {"trial", "it does not split files; the option trial of the call does", has_one_word}});

/// Returns notes on columns that are carried along and look like settings, or like weights if the sheet has none.
std::vector<std::string> notes_on_carried(const StudySheet& sheet) {
  std::vector<std::string> notes;
  const bool has_weights = std::ranges::any_of(sheet.names, names_weights);
  for (std::size_t i = 0; i < sheet.columns.size(); ++i) {
    if (!has_weights && has_unit_of_mass(sheet.columns[i]))
      notes.push_back(sheet.file.string() + ": column " + sheet.columns[i] +
                      " is carried along; if it is the weight of the body, name it weight, and the height height");
    const auto word = std::ranges::find(options_words, column_key(sheet.columns[i]), &OptionsWord::key);
    if (word == options_words.end()) continue;
    std::vector<std::string> cells;
    for (const SheetLine& line : sheet.lines)
      if (i < line.entry.cells.size() && !line.entry.cells[i].empty()) cells.push_back(line.entry.cells[i]);
    if (word->is_setting(cells))
      notes.push_back(sheet.file.string() + ": column " + sheet.columns[i] + " is carried along; " +
                      std::string(word->setting));
  }
  return notes;
}

}  // namespace

std::string StudySheet::locate(const SheetLine& line) const {
  return format("%s, line %zu", file.string().c_str(), line.number);
}

std::function<std::string(const SheetEntry& entry)> StudySheet::reader_for(const std::string& column) const {
  const auto found = std::ranges::find(columns, column_key(column), column_key);
  switch (found == columns.end() ? sheet_column(column).role : ColumnRole::carried) {
    case ColumnRole::participant:
      return &SheetEntry::participant;
    case ColumnRole::session:
      return &SheetEntry::session;
    case ColumnRole::group:
      return &SheetEntry::group;
    case ColumnRole::condition:
      return &SheetEntry::condition;
    default:
      break;
  }
  if (found == columns.end())
    throw Error(Code::column_missing, file.string(), "has no column '" + column + "' of participants or conditions",
                "name participant_id, session, group, condition or another column of the sheet: " +
                    joined(names, ", ", one_line));
  return [place = static_cast<std::size_t>(found - columns.begin())](const SheetEntry& entry) {
    return place < entry.cells.size() ? entry.cells[place] : std::string();
  };
}

bool names_groups(const std::string& column) {
  return sheet_column(column).role == ColumnRole::group;
}

bool names_weights(const std::string& column) {
  return sheet_column(column).role == ColumnRole::mass;
}

bool names_heights(const std::string& column) {
  return sheet_column(column).role == ColumnRole::height;
}

bool names_ages(const std::string& column) {
  constexpr auto known =
      std::to_array<std::string_view>({"age", "age_years", "age_in_years", "alter", "alter_jahre", "alter_in_jahren"});
  return std::ranges::any_of(known,
                             [key = column_key(column)](std::string_view name) { return column_key(name) == key; });
}

bool names_body_mass_indices(const std::string& column) {
  constexpr auto known = std::to_array<std::string_view>({"bmi", "bodymassindex", "imc"});
  constexpr auto units = std::to_array<std::string_view>({"", "kgm2", "kgm^2", "kgm\u00B2", "inkgm2", "inkgm\u00B2"});
  const std::string key = column_key(column);
  return std::ranges::any_of(known, [&](std::string_view name) {
    return key.starts_with(name) && std::ranges::find(units, key.substr(name.size())) != units.end();
  });
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

bool looks_like_sheet(const std::filesystem::path& path) {
  try {
    constexpr std::size_t max_lines = 1000;  // a recording has more samples
    const std::vector<std::vector<std::string>> rows = read_spreadsheet(path);
    const std::vector<std::string>& names = rows.front();
    std::set<ColumnRole> roles;
    for (const SheetColumn& column : sheet_columns(names)) roles.insert(column.role);
    const bool names_recordings = roles.contains(ColumnRole::participant) || roles.contains(ColumnRole::file);
    return rows.size() <= max_lines && names_recordings && roles.size() - roles.count(ColumnRole::carried) > 1 &&
           std::ranges::none_of(names, recording::is_time_name);
  } catch (const Error&) {  // not a table of text
    return false;
  }
}

StudySheet read_sheet(const std::filesystem::path& path) {
  std::vector<std::vector<std::string>> rows = read_spreadsheet(path);
  refuse_recording(rows, path);
  std::vector<std::string>& names = rows.front();
  while (!names.empty() && names.back().empty()) names.pop_back();
  std::vector<SheetColumn> columns = read_columns(names, sidecar_units(path), path.string() + ", line 1");
  find_other_units(rows, columns);
  StudySheet sheet{path, {}, {}, names};
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i].role == ColumnRole::carried) sheet.columns.push_back(names[i]);
    if (columns[i].role == ColumnRole::participant) sheet.participant_column = names[i];
    if (columns[i].role == ColumnRole::group) sheet.group_column = names[i];
  }
  for (std::size_t row = 1; row < rows.size(); ++row) {
    if (std::ranges::all_of(rows[row], [](const std::string& cell) { return cell.empty(); })) continue;
    const std::string where = format("%s, line %zu", path.string().c_str(), row + 1);
    sheet.lines.push_back(read_line(columns, names, rows[row], row + 1, where));
  }
  if (sheet.lines.empty())
    throw Error(Code::file_empty, path.string(), "has no line below its names", "add a line per recording or person");
  sheet.notes = notes_on_carried(sheet);
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
