// Columns of a study's sheet: see sheet_columns.hpp.
#include "identify/study/detail/sheet_columns.hpp"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "identify/study/detail/text_key.hpp"
#include "identify/study/reading_option.hpp"

namespace decid {
namespace {

struct KnownNames {
  ColumnRole role;
  std::vector<std::string> keys;
};

std::vector<std::string> keys_of(std::initializer_list<std::string_view> names) {
  return column_keys(std::span(names.begin(), names.size()));
}

/// English and German, as laboratories name the columns of their sheets. A unit may follow weights and heights.
std::span<const KnownNames> known_names() {
  static const std::vector<KnownNames> known{
      {ColumnRole::participant, keys_of({"id", "participant", "participant_id", "subject", "subject_id", "sub_id",
                                         "person", "person_id", "patient", "patient_id", "proband", "proband_id"})},
      {ColumnRole::session, keys_of({"session", "session_id", "sitzung"})},
      {ColumnRole::group, keys_of({"group", "gruppe"})},
      {ColumnRole::condition, keys_of({"condition", "bedingung"})},
      {ColumnRole::file, keys_of({"file", "filename", "path", "recording", "datei", "dateiname", "aufnahme"})},
      {ColumnRole::mass, keys_of({"mass", "body_mass", "weight", "body_weight", "masse", "gewicht",
                                  "k\u00f6rpergewicht", "koerpergewicht"})},
      {ColumnRole::height, keys_of({"height", "body_height", "gr\u00f6\u00dfe", "groesse", "k\u00f6rpergr\u00f6\u00dfe",
                                    "koerpergroesse"})},
      {ColumnRole::protocol, keys_of({"protocol", "protokoll"})}};
  return known;
}

/// The most important ones in French, Spanish, Portuguese, Italian and Dutch, and rarer English ones: a body that is
/// not read would be the assumed one. In sheets of other languages they may mean something else (German Taille: the
/// waist).
std::span<const KnownNames> further_names() {
  static const std::vector<KnownNames> known{
      {ColumnRole::height,
       keys_of({"stature", "taille", "altura", "estatura", "talla", "altezza", "statura", "lengte"})},
      {ColumnRole::mass, keys_of({"poids", "poids_corporel", "peso", "peso_corporal"})},
      {ColumnRole::participant, keys_of({"paziente", "paciente", "sujet", "sujeto", "soggetto"})},
      {ColumnRole::group, keys_of({"groupe", "grupo", "gruppo"})},
      {ColumnRole::file, keys_of({"fichier", "archivo"})}};
  return known;
}

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
  static const std::vector<std::string> numbers = column_keys(number_endings), names = column_keys(name_endings),
                                        codes = column_keys(person_codes);
  const auto has = [](const std::vector<std::string>& keys, std::string_view text) {
    return std::ranges::find(keys, text) != keys.end();
  };
  for (const std::string_view person : numbered_persons) {
    if (!key.starts_with(person)) continue;
    const std::string_view ending = std::string_view(key).substr(person.size());
    if (has(numbers, ending)) return ColumnNaming::number;
    if (has(names, ending)) return ColumnNaming::name;
  }
  if (has(codes, key)) return ColumnNaming::code;
  return {};
}

struct KnownUnits {
  ColumnRole role;
  double size;  ///< in kg or m; 0: not read
  std::vector<std::string_view> names;
};

/// A column in a unit that is not read is an error: carried along as any other column it would leave the body assumed.
/// "lbav" and "ini" are UCUM's [lb_av] and [in_i].
std::span<const KnownUnits> known_units() {
  static const std::vector<KnownUnits> known{
      {ColumnRole::mass, 1.0, {"kg", "kgs", "kilogram", "kilograms"}},
      {ColumnRole::mass, 0.45359237, {"lb", "lbs", "lbav", "pound", "pounds"}},
      {ColumnRole::mass, 0.0, {"pfund", "g", "grams", "n", "newton", "st", "stone", "oz"}},
      {ColumnRole::height, 1.0, {"m", "metre", "metres", "meter", "meters"}},
      {ColumnRole::height, centimetre, {"cm", "centimetre", "centimetres", "centimeter", "centimeters"}},
      {ColumnRole::height, 0.001, {"mm"}},
      {ColumnRole::height, 0.0254, {"in", "inch", "inches", "ini", "zoll"}},
      {ColumnRole::height, 0.0, {"ft", "foot", "feet", "ftin"}}};
  return known;
}

/// Returns SheetColumn::per_unit of a unit of this size: columns in cm may hold metres too.
double size_in_columns(double size) {
  return size == centimetre ? 1.0 : size;
}

/// Returns the meaning of a name, or of one with a unit: "weight", "weight_kg", "Height in cm", "Poids en kg".
std::optional<SheetColumn> find_name(std::span<const KnownNames> known, const std::string& key, ColumnNaming naming) {
  constexpr auto joints = std::to_array<std::string_view>({"", "in", "en", "em"});
  for (const auto& [role, keys] : known)
    for (const std::string& begin : keys) {
      if (!key.starts_with(begin)) continue;
      if (key == begin) return SheetColumn{role, 1.0, {}, false, naming};
      for (const std::string_view joint : joints) {
        if (!key.substr(begin.size()).starts_with(joint)) continue;
        if (const std::optional<double> size = body_unit(role, key.substr(begin.size() + joint.size())))
          return SheetColumn{role, size_in_columns(*size), {}, true, naming};
      }
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
  if (const auto found = find_name(known_names(), key, ColumnNaming::sure)) return *found;
  if (const auto found = find_name(further_names(), key, ColumnNaming::further)) return *found;
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
  std::set<ColumnRole> surely;
  for (const SheetColumn& column : columns)
    if (column.naming < ColumnNaming::further) surely.insert(column.role);
  for (SheetColumn& column : columns)
    if (column.naming == ColumnNaming::further && surely.contains(column.role)) column = {ColumnRole::carried};
  return columns;
}

std::optional<double> body_unit(ColumnRole role, const std::string& unit) {
  const std::string key = column_key(unit);
  for (const KnownUnits& known : known_units())
    if (known.role == role && std::ranges::find(known.names, key) != known.names.end()) return known.size;
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
  column.per_unit = size_in_columns(body_unit(column.role, unit).value_or(0.0));
  column.has_sidecar_unit = true;
}

}  // namespace decid
