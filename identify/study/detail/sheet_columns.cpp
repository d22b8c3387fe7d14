// Columns of a study's sheet: see sheet_columns.hpp.
#include "identify/study/detail/sheet_columns.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "identify/study/detail/text_key.hpp"
#include "identify/study/reading_option.hpp"

namespace decid {
namespace {

struct KnownName {
  std::string_view name;
  ColumnRole role;
};

/// English and German, as laboratories name the columns of their sheets. A unit may follow weights and heights.
constexpr auto known_names = std::to_array<KnownName>({
    {"id", ColumnRole::participant},
    {"participant", ColumnRole::participant},
    {"participant_id", ColumnRole::participant},
    {"subject", ColumnRole::participant},
    {"subject_id", ColumnRole::participant},
    {"sub_id", ColumnRole::participant},
    {"person", ColumnRole::participant},
    {"person_id", ColumnRole::participant},
    {"patient", ColumnRole::participant},
    {"patient_id", ColumnRole::participant},
    {"proband", ColumnRole::participant},
    {"proband_id", ColumnRole::participant},
    {"session", ColumnRole::session},
    {"session_id", ColumnRole::session},
    {"sitzung", ColumnRole::session},
    {"group", ColumnRole::group},
    {"gruppe", ColumnRole::group},
    {"condition", ColumnRole::condition},
    {"bedingung", ColumnRole::condition},
    {"file", ColumnRole::file},
    {"filename", ColumnRole::file},
    {"path", ColumnRole::file},
    {"recording", ColumnRole::file},
    {"datei", ColumnRole::file},
    {"dateiname", ColumnRole::file},
    {"aufnahme", ColumnRole::file},
    {"mass", ColumnRole::mass},
    {"body_mass", ColumnRole::mass},
    {"weight", ColumnRole::mass},
    {"body_weight", ColumnRole::mass},
    {"masse", ColumnRole::mass},
    {"gewicht", ColumnRole::mass},
    {"k\u00f6rpergewicht", ColumnRole::mass},
    {"koerpergewicht", ColumnRole::mass},
    {"height", ColumnRole::height},
    {"body_height", ColumnRole::height},
    {"gr\u00f6\u00dfe", ColumnRole::height},
    {"groesse", ColumnRole::height},
    {"k\u00f6rpergr\u00f6\u00dfe", ColumnRole::height},
    {"koerpergroesse", ColumnRole::height},
    {"protocol", ColumnRole::protocol},
    {"protokoll", ColumnRole::protocol},
});

/// The most important ones in French, Spanish, Portuguese, Italian and Dutch, and rarer English ones: a body that is
/// not read would be the assumed one. In sheets of other languages they may mean something else (German Taille: the
/// waist).
constexpr auto further_names = std::to_array<KnownName>({
    {"stature", ColumnRole::height},
    {"poids", ColumnRole::mass},
    {"poids_corporel", ColumnRole::mass},
    {"taille", ColumnRole::height},
    {"peso", ColumnRole::mass},
    {"peso_corporal", ColumnRole::mass},
    {"altura", ColumnRole::height},
    {"estatura", ColumnRole::height},
    {"talla", ColumnRole::height},
    {"altezza", ColumnRole::height},
    {"statura", ColumnRole::height},
    {"lengte", ColumnRole::height},
    {"paziente", ColumnRole::participant},
    {"paciente", ColumnRole::participant},
    {"sujet", ColumnRole::participant},
    {"sujeto", ColumnRole::participant},
    {"soggetto", ColumnRole::participant},
    {"groupe", ColumnRole::group},
    {"grupo", ColumnRole::group},
    {"gruppo", ColumnRole::group},
    {"fichier", ColumnRole::file},
    {"archivo", ColumnRole::file},
});

/// Persons as numbers or names: each of these with one of the endings, such as "VP-Nr".
constexpr auto numbered_persons = std::to_array<std::string_view>(
    {"participant", "subject", "person", "patient", "proband", "probandin", "versuchsperson", "teilnehmer",
     "teilnehmerin", "testperson", "volunteer", "sub", "subj", "pat", "pbn", "vp", "vpn", "tn"});
constexpr auto number_endings =
    std::to_array<std::string_view>({"id", "no", "nr", "num", "number", "nummer", "n\u00B0", "n\u00BA", "\u2116"});
constexpr auto name_endings = std::to_array<std::string_view>({"code", "kennung", "name", "k\u00FCrzel", "kuerzel"});
constexpr auto person_codes =
    std::to_array<std::string_view>({"code", "pseudonym", "pid", "id no", "id nr", "id number", "record id", "subj",
                                     "vp", "vpn", "versuchsperson", "teilnehmer", "testperson"});

/// Returns how surely a column names the person, by its key; nothing for a column of anything else.
std::optional<ColumnNaming> naming_of_person(const std::string& key) {
  for (const std::string_view person : numbered_persons) {
    if (!key.starts_with(person)) continue;
    const std::string ending = key.substr(person.size());
    if (std::ranges::find(number_endings, ending, column_key) != number_endings.end()) return ColumnNaming::number;
    if (std::ranges::find(name_endings, ending, column_key) != name_endings.end()) return ColumnNaming::name;
  }
  if (std::ranges::find(person_codes, key, column_key) != person_codes.end()) return ColumnNaming::code;
  return {};
}

struct KnownUnit {
  ColumnRole role;
  std::string_view unit;
  double size;  ///< in kg or m; 0: not read
};

/// A column in a unit that is not read is an error: carried along as any other column it would leave the body assumed.
/// "lbav" and "ini" are UCUM's [lb_av] and [in_i].
constexpr auto known_units = std::to_array<KnownUnit>({
    {ColumnRole::mass, "kg", 1.0},
    {ColumnRole::mass, "kgs", 1.0},
    {ColumnRole::mass, "kilogram", 1.0},
    {ColumnRole::mass, "kilograms", 1.0},
    {ColumnRole::mass, "lb", 0.45359237},
    {ColumnRole::mass, "lbs", 0.45359237},
    {ColumnRole::mass, "lbav", 0.45359237},
    {ColumnRole::mass, "pound", 0.45359237},
    {ColumnRole::mass, "pounds", 0.45359237},
    {ColumnRole::mass, "pfund", 0.0},
    {ColumnRole::mass, "g", 0.0},
    {ColumnRole::mass, "grams", 0.0},
    {ColumnRole::mass, "n", 0.0},
    {ColumnRole::mass, "newton", 0.0},
    {ColumnRole::mass, "st", 0.0},
    {ColumnRole::mass, "stone", 0.0},
    {ColumnRole::mass, "oz", 0.0},
    {ColumnRole::height, "m", 1.0},
    {ColumnRole::height, "metre", 1.0},
    {ColumnRole::height, "metres", 1.0},
    {ColumnRole::height, "meter", 1.0},
    {ColumnRole::height, "meters", 1.0},
    {ColumnRole::height, "cm", centimetre},
    {ColumnRole::height, "centimetre", centimetre},
    {ColumnRole::height, "centimetres", centimetre},
    {ColumnRole::height, "centimeter", centimetre},
    {ColumnRole::height, "centimeters", centimetre},
    {ColumnRole::height, "mm", 0.001},
    {ColumnRole::height, "in", 0.0254},
    {ColumnRole::height, "inch", 0.0254},
    {ColumnRole::height, "inches", 0.0254},
    {ColumnRole::height, "ini", 0.0254},
    {ColumnRole::height, "zoll", 0.0254},
    {ColumnRole::height, "ft", 0.0},
    {ColumnRole::height, "foot", 0.0},
    {ColumnRole::height, "feet", 0.0},
    {ColumnRole::height, "ftin", 0.0},
});

/// Returns SheetColumn::per_unit of a unit: columns in cm may hold metres too.
double size_in_columns(const KnownUnit& unit) {
  return unit.size == centimetre ? 1.0 : unit.size;
}

/// Returns the meaning of a name, or of one with a unit: "weight", "weight_kg", "Height in cm", "Poids en kg".
std::optional<SheetColumn> find_name(std::span<const KnownName> names, const std::string& key, ColumnNaming naming) {
  constexpr auto joints = std::to_array<std::string_view>({"", "in", "en", "em"});
  for (const KnownName& known : names) {
    const std::string begin = column_key(known.name);
    if (!key.starts_with(begin)) continue;
    if (key == begin) return SheetColumn{known.role, 1.0, {}, false, naming};
    for (const KnownUnit& unit : known_units)
      for (const std::string_view joint : joints)
        if (unit.role == known.role && key.substr(begin.size()) == std::string(joint) + std::string(unit.unit))
          return SheetColumn{known.role, size_in_columns(unit), {}, true, naming};
  }
  return {};
}

/// Returns true for a weight in German or Dutch, where Taille is the waist and not the height.
bool has_german_weight(const std::string& name) {
  return column_key(name).find("gewicht") != std::string::npos;
}

}  // namespace

SheetColumn sheet_column(const std::string& name) {
  const std::string key = column_key(name);
  if (const auto found = find_name(known_names, key, ColumnNaming::sure)) return *found;
  if (const auto found = find_name(further_names, key, ColumnNaming::further)) return *found;
  if (const std::optional<ColumnNaming> naming = naming_of_person(key))
    return {ColumnRole::participant, 1.0, {}, false, *naming};
  std::string option = find_reading_option(name);
  return option.empty() ? SheetColumn{ColumnRole::carried} : SheetColumn{ColumnRole::reading, 1.0, std::move(option)};
}

std::vector<SheetColumn> sheet_columns(const std::vector<std::string>& names) {
  std::vector<SheetColumn> columns;
  std::optional<std::size_t> person;
  for (const std::string& name : names) {
    const SheetColumn& column = columns.emplace_back(sheet_column(name));
    if (column.role == ColumnRole::participant && (!person || column.naming < columns[*person].naming))
      person = columns.size() - 1;
  }
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i].role != ColumnRole::participant) continue;
    const bool is_alike = columns[i].naming == ColumnNaming::sure || column_key(names[i]) == column_key(names[*person]);
    if (columns[i].naming != columns[*person].naming || !is_alike) columns[i] = {ColumnRole::carried};
  }
  if (std::ranges::any_of(names, has_german_weight))
    for (std::size_t i = 0; i < columns.size(); ++i)
      if (columns[i].role == ColumnRole::height && column_key(names[i]).starts_with("taille"))
        columns[i] = {ColumnRole::carried};
  const std::vector<SheetColumn> all = columns;
  for (SheetColumn& column : columns) {
    const auto is_surer = [&](const SheetColumn& other) {
      return other.role == column.role && other.naming < column.naming;
    };
    if (column.naming == ColumnNaming::further && std::ranges::any_of(all, is_surer)) column = {ColumnRole::carried};
  }
  return columns;
}

std::optional<double> body_unit(ColumnRole role, const std::string& unit) {
  const std::string key = column_key(unit);
  for (const KnownUnit& known : known_units)
    if (known.role == role && known.unit == key) return known.size;
  return {};
}

bool has_unit_of_mass(const std::string& name) {
  constexpr auto endings = std::to_array<std::string_view>({"kg", "kgs", "lb", "lbs"});
  const std::string key = text_key(name);
  std::size_t end = key.size();
  while (end > 0 && (key[end - 1] == ')' || key[end - 1] == ']' || key[end - 1] == ' ')) --end;
  std::size_t begin = end;
  while (begin > 0 && key[begin - 1] >= 'a' && key[begin - 1] <= 'z') --begin;
  if (std::ranges::find(endings, std::string_view(key).substr(begin, end - begin)) == endings.end()) return false;
  const std::size_t before = key.find_last_not_of(" ([", begin - 1);
  return begin == 0 || before == std::string::npos || key[before] != '/';
}

void set_sidecar_unit(const std::string& unit, SheetColumn& column) {
  if (column.has_unit || (column.role != ColumnRole::mass && column.role != ColumnRole::height)) return;
  const std::string key = column_key(unit);
  const auto found = std::ranges::find_if(
      known_units, [&](const KnownUnit& known) { return known.role == column.role && known.unit == key; });
  column.per_unit = found == known_units.end() ? 0.0 : size_in_columns(*found);
  column.has_sidecar_unit = true;
}

}  // namespace decid
