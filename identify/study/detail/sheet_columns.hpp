// The meaning of the columns of a study's sheet, by their names. Not installed.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace decid {

/// The meaning of a column: a cell of the entry, a value of decid's, or an option of reading.
enum class ColumnRole { carried, participant, session, group, condition, file, mass, height, protocol, reading };

/// How surely a column has its meaning: by an English or German word; of persons also by a number, a name or code, or
/// the word code; by a further word, which may mean something else in another language. If several columns may be the
/// person's, the first of the surest is, and the others are carried along; so is a further one beside a surer one.
enum class ColumnNaming { sure, number, name, code, further };

inline constexpr double centimetre = 0.01;  ///< the size of cm in m, as body_unit() returns it

struct SheetColumn {
  ColumnRole role;
  double per_unit = 1.0;    ///< kg of a weight, or metres of a height, in one unit; a height in "1" is in m or cm
  std::string option = {};  ///< of reading
  bool has_unit = false;    ///< a weight or a height with a unit in its name
  ColumnNaming naming = ColumnNaming::sure;
  bool has_sidecar_unit = false;
  std::string other_unit = {};  ///< a weight's or height's cell in other units than kg, m and cm, and its line
};

/// Returns what a column of this name means on its own.
SheetColumn sheet_column(const std::string& name);

/// Returns what the columns of a sheet mean together (ColumnNaming). Several columns of people that are sure, or that
/// have the same name, keep this meaning.
std::vector<SheetColumn> sheet_columns(const std::vector<std::string>& names);

/// Returns the kg or m of a weight's or a height's unit; 0 for a unit that is not read, nothing for no unit.
std::optional<double> body_unit(ColumnRole role, const std::string& unit);

/// Returns true for the name of a column that is or ends in a unit of mass, except one per mass: "kg", "Vikt (kg)",
/// "lean_mass_kg", but not "torque (Nm/kg)".
bool has_unit_of_mass(const std::string& name);

/// Gives a weight or a height without a unit in its name the unit of the sheet's sidecar.
void set_sidecar_unit(const std::string& unit, SheetColumn& column);

}  // namespace decid
