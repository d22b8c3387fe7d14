// The meaning of the columns of a study's sheet, by their names. Not installed.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace decid {

/// The meaning of a column: a cell of the entry, a value of decid's, or an option of reading.
enum class ColumnRole { carried, participant, session, group, condition, file, mass, height, protocol, reading };

/// How surely a column names the person: by the word alone or an ID, a number of persons, a name or code of persons, a
/// code. If several may, the first of the surest does, and the others are carried along.
enum class PersonNaming { sure, number, name, code };

struct SheetColumn {
  ColumnRole role;
  double per_unit = 1.0;    ///< kg of a weight, or metres of a height, in one unit; a height in "1" is in m or cm
  std::string option = {};  ///< of reading
  bool has_unit = false;    ///< a weight or a height with a unit in its name
  PersonNaming naming = PersonNaming::sure;
};

/// Returns what a column of this name means on its own.
SheetColumn sheet_column(const std::string& name);

/// Returns what the columns of a sheet mean together: the first of its surest columns of people names the person.
/// Several that are sure, or that have the same name, keep this meaning.
std::vector<SheetColumn> sheet_columns(const std::vector<std::string>& names);

/// Returns the kg or m of a weight's or a height's unit; 1 for cm too, as in SheetColumn. Nothing for a unit that is
/// not read.
std::optional<double> body_unit(ColumnRole role, const std::string& unit);

/// Returns true for the name of a column that ends in a unit of mass: "Vikt (kg)", "lean_mass_kg".
bool has_unit_of_mass(const std::string& name);

/// Gives a weight or a height without a unit in its name the unit of the sheet's sidecar.
void set_sidecar_unit(const std::string& unit, SheetColumn& column);

}  // namespace decid
