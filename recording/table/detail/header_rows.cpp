// Reads headers of several rows: see header_rows.hpp.
#include "recording/table/detail/header_rows.hpp"

#include <algorithm>
#include <set>

#include "base/text.hpp"
#include "recording/table/cells.hpp"
#include "recording/table/columns.hpp"

namespace decid::recording {

namespace {

using Cells = std::vector<std::string_view>;
using Names = std::vector<std::string>;

std::size_t filled(const Cells& cells) {
  return static_cast<std::size_t>(std::ranges::count_if(cells, [](auto cell) { return !cell.empty(); }));
}

/// Returns true for a row that counts samples or numbers the markers.
bool half_are_numbers(const Cells& cells) {
  const auto numbers = std::ranges::count_if(cells, [](auto cell) { return parse_number(cell).is_number; });
  return 2 * static_cast<std::size_t>(numbers) >= filled(cells);
}

/// Returns true if all columns have the same word ("CAL", "ORIGINAL"), which cannot distinguish them.
bool is_one_word(const Cells& cells) {
  std::set<std::string_view> different(cells.begin(), cells.end());
  different.erase("");
  return different.size() == 1;
}

/// Gives each empty cell the text to its left, because programs write the name of a group of columns once.
Cells filled_up(Cells cells, std::size_t columns) {
  cells.resize(columns);
  const auto first = std::ranges::find_if(cells, [](auto cell) { return !cell.empty(); });
  std::string_view last;
  for (auto cell = first; cell != cells.end(); ++cell) {
    if (!cell->empty()) last = *cell;
    *cell = last;
  }
  return cells;
}

bool are_different(const Names& names) {
  std::set<std::string_view> different(names.begin(), names.end());
  different.erase("");
  const auto count = static_cast<std::size_t>(std::ranges::count_if(names, [](auto& name) { return !name.empty(); }));
  return different.size() == count;
}

bool are_unique(const Names& names) {
  const auto is_axis = [](const std::string& name) {
    return one_of(name, {"x", "y", "z", "X", "Y", "Z", "RX", "RY", "RZ", "TX", "TY", "TZ"});
  };
  return are_different(names) && std::ranges::none_of(names, is_axis);
}

bool is_time_unit(std::string_view cell) {
  return one_of(lower_case(unit_of_cell(cell).value_or(std::string())),
                {"s", "sec", "seconds", "sek", "sekunden", "ms", "msec", "msecs", "us", "min"});
}

/// Returns true if each cell above these names is empty or a unit, also one that decid does not convert ("inch").
/// Two cells must be units, or the time's: one "m" may be the name of a group.
bool are_units_of(const Cells& names, const Cells& cells) {
  bool has_time_unit = false;
  for (std::size_t c = 0; c < names.size(); ++c)
    has_time_unit = has_time_unit || (is_time_name(names[c]) && is_time_unit(cells[c]));
  return (has_time_unit || filled(cells) > 1) && std::ranges::all_of(cells, [](std::string_view cell) {
           const std::string named = "x (" + std::string(cell) + ")";
           return !parse_number(cell).is_number && (unit_of_cell(cell) || unit_in(named) ||
                                                    find_metres_per_unit(named) || other_quantity(named) != nullptr);
         });
}

/// Returns true for a row that continues the names above it: ",AP," below "Time,CoM,Platform".
bool continues(const Cells& row, const Cells& above, std::size_t columns) {
  return row.size() > 1 && row.size() == above.size() && row.size() <= columns + 1 && row[0].empty() &&
         filled(row) > 0 && is_time_name(above[0]) && !are_units(above) && std::ranges::none_of(row, is_value) &&
         std::ranges::none_of(above, is_value);
}

/// Names the columns of Qualisys: frame and time, then X, Y and Z of each marker in mm.
Names of_markers(const Cells& row, std::size_t columns) {
  const std::size_t markers = filled(row) - 1;
  if (markers == 0 || 3 * markers > columns) return {};
  Names names;
  for (std::size_t i = 0; i + 3 * markers < columns; ++i) names.push_back(i == 0 ? "Frame" : "Time");
  for (std::size_t i = 1; names.size() < columns; ++i)
    for (const char* axis : {" X (mm)", " Y (mm)", " Z (mm)"}) names.push_back(std::string(row[i]) + axis);
  return names;
}

/// Names the columns of AcqKnowledge. Above the row "min,CH1,CH2", two lines for each channel hold its name and its
/// unit.
Names of_channels(const HeaderRows& rows, std::size_t row, std::size_t columns) {
  const std::size_t channels = columns - 1;
  if (row < 2 * channels) return {};
  Names names{"time (" + std::string(rows[row][0]) + ")"};
  for (std::size_t i = row - 2 * channels; i < row; i += 2) {
    if (rows[i].empty() || rows[i + 1].empty()) return {};
    names.push_back(with_unit(std::string(rows[i][0]), rows[i + 1][0]));
  }
  return names;
}

/// Returns true if LabVIEW wrote no times; the first column is then empty.
bool lacks_times(const HeaderRows& rows) {
  return std::ranges::any_of(
      rows, [](const Cells& row) { return row.size() > 1 && row[0] == "X_Columns" && row[1] == "No"; });
}

/// Adds the units of LabVIEW's last header above the row of names.
void add_labview_units(const HeaderRows& rows, std::size_t row, Names& names) {
  for (std::size_t i = row; i-- > 0;) {
    if (rows[i].empty() || rows[i][0] != "Y_Unit_Label") continue;
    for (std::size_t c = 1; c < std::min(rows[i].size(), names.size()); ++c) names[c] = with_unit(names[c], rows[i][c]);
    return;
  }
}

/// Adds LabChart's units of each channel.
void add_labchart_units(const HeaderRows& rows, Names& names) {
  for (const Cells& row : rows)
    if (!row.empty() && row[0] == "UnitName=")
      for (std::size_t c = 1; c < std::min(row.size(), names.size()); ++c)
        if (row[c] != "*") names[c] = with_unit(names[c], row[c]);
}

Names of_known_format(const HeaderRows& rows, std::size_t columns) {
  for (std::size_t i = rows.size(); i-- > 0;) {
    const Cells& row = rows[i];
    if (row.empty()) continue;
    if (row[0] == "MARKER_NAMES" && i + 1 == rows.size()) return of_markers(row, columns);
    if ((row[0] == "ChannelTitle=" || row[0] == "X_Value" ||
         (row[0].empty() && i > 0 && rows[i - 1][0].starts_with("***End_of_Header"))) &&
        row.size() >= columns) {
      Names names(row.begin(), row.begin() + static_cast<std::ptrdiff_t>(columns));
      names[0] = row[0].empty() || lacks_times(rows) ? "" : "time (s)";
      if (row[0] == "X_Value") add_labview_units(rows, i, names);
      if (row[0] == "ChannelTitle=") add_labchart_units(rows, names);
      return names;
    }
    if (row.size() >= 2 && row[1] == "CH1" && row.size() >= columns) return of_channels(rows, i, columns);
  }
  return {};
}

}  // namespace

std::vector<std::string> names_of_rows(const HeaderRows& rows, std::size_t columns) {
  if (rows.empty() || columns < 2) return {};
  Names names = of_known_format(rows, columns);
  if (names.empty()) {
    // Reads upwards while the rows are as wide as the table.
    Cells units;
    bool combined = false, units_above = false;
    for (std::size_t i = rows.size(); i-- > 0;) {
      const Cells& row = rows[i];
      const bool is_lower = names.empty() && i > 0 && continues(row, rows[i - 1], columns);
      if (row.size() < 2 || row.size() > columns + 1 || (filled(row) < 2 && !is_lower)) break;
      if (names.empty() && units.empty() && i > 0 && are_units(row)) {
        units = row;
        continue;
      }
      if (half_are_numbers(row)) continue;
      if (is_one_word(row) && one_of(row.back(), {"CAL", "RAW", "ORIGINAL", "DERIVED", "PROCESSED", "Marker"})) {
        combined = true;
        continue;
      }
      if (names.empty()) {
        names.assign(row.begin(), row.end());
        names.resize(columns);
        if (is_lower) {
          const Cells above = filled_up(rows[i - 1], columns);
          for (std::size_t c = 0; c < columns; ++c)
            names[c] = std::string(above[c]) + (names[c].empty() || above[c].empty() ? "" : " ") + names[c];
          combined = true;
        } else if (units.empty() && i > 0 && rows[i - 1].size() == row.size() && are_units_of(row, rows[i - 1])) {
          units = rows[i - 1];
          combined = units_above = true;
          break;
        }
      } else if (!row[0].empty()) {  // A row of groups leaves the column of frames or times empty.
        break;
      } else {
        const Cells above = filled_up(row, columns);
        for (std::size_t c = 0; c < columns; ++c)
          if (!above[c].empty() && !is_time_name(names[c]))
            names[c] = std::string(above[c]) + (names[c].empty() ? "" : " ") + names[c];
        combined = true;
      }
      if (are_unique(names)) break;
    }
    if (!combined || !(units_above ? are_different(names) : are_unique(names))) return {};
    units.resize(columns);
    for (std::size_t c = 0; c < columns; ++c) names[c] = with_unit(names[c], units[c]);
  }
  for (std::size_t c = 0; c < names.size(); ++c)
    if (names[c].empty()) names[c] = "column " + std::to_string(c + 1);
  return names;
}

void add_section_rate(const HeaderRows& rows, std::vector<StatedRate>& rates) {
  for (std::size_t i = 1; i < rows.size(); ++i) {
    if (rows[i].empty() || filled(rows[i]) != 1 || rows[i - 1].empty() || filled(rows[i - 1]) != 1) continue;
    const Parsed number = parse_number(rows[i][0]);
    if (number.is_number && is_sample_rate(number.value) &&
        one_of(rows[i - 1][0], {"Trajectories", "Devices", "Model Outputs", "Joints", "Segments", "Events", "MX"}))
      rates.push_back({number.value, std::string(rows[i - 1][0]), true});
  }
}

}  // namespace decid::recording
