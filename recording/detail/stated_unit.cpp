// Units in words above a table: see stated_unit.hpp.
#include "recording/detail/stated_unit.hpp"

#include <algorithm>

#include "recording/detail/stated_rate.hpp"
#include "recording/table/cells.hpp"
#include "recording/table/columns.hpp"

namespace decid::recording {

namespace {

bool has_unit(const std::string& name) {
  return unit_in(name) || find_metres_per_unit(name) || other_quantity(name) != nullptr;
}

bool is_unit(std::string_view text) {
  return has_unit(with_unit("x", text));
}

bool counts_samples(const std::string& name) {
  return std::ranges::any_of(words(name), [](const std::string& word) {
    return one_of(word, {"frame", "subframe", "sample", "index", "row", "item", "trial", "marker", "event"});
  });
}

bool is_coordinate(const std::string& name) {
  const std::vector<std::string> parts = words(name);
  return one_of(parts.back(), {"x", "y", "z"}) && std::ranges::none_of(parts, [](const std::string& word) {
           return one_of(word, {"rotation", "rot", "angle", "angles", "orientation", "quaternion"});
         });
}

/// Returns the only unit of the given kind; empty without one, and for several.
std::string only_unit(const std::vector<StatedUnit>& units, bool is_length) {
  std::string found;
  for (const StatedUnit& one : units) {
    if (one.is_length != is_length || one.unit == found) continue;
    if (!found.empty()) return {};
    found = one.unit;
  }
  return found;
}

}  // namespace

void add_stated_unit(std::string_view line, std::vector<StatedUnit>& units) {
  const std::vector<std::string_view> fields = fields_of(line);
  for (std::size_t i = 0; i + 1 < fields.size(); ++i) {
    const std::string phrase = letters_of(fields[i]);
    const bool is_length =
        one_of(phrase, {"lengthunit", "lengthunits", "unitsoflength", "positionunit", "positionunits", "distanceunit",
                        "distanceunits", "coordinateunit", "coordinateunits", "l\u00e4ngeneinheit", "laengeneinheit"});
    if (!is_length && !one_of(phrase, {"unit", "units", "einheit", "einheiten", "unit\u00e9", "unit\u00e9s", "unidad",
                                       "unidades", "dataunit", "dataunits"}))
      continue;
    if (!is_unit(fields[i + 1]) || (i + 2 < fields.size() && is_unit(fields[i + 2]))) continue;
    units.push_back({std::string(fields[i + 1]), is_length});
  }
}

void add_units(const std::vector<StatedUnit>& units, std::vector<std::string>& names) {
  const std::string of_all = only_unit(units, false), of_lengths = only_unit(units, true);
  if (of_all.empty() && of_lengths.empty()) return;
  for (std::string& name : names) {
    const bool counts = counts_samples(name) && !is_coordinate(name);  // NDI's "Marker_1 x" is a position
    if (is_time_name(name) || counts || has_unit(name)) continue;
    name = with_unit(name, of_lengths.empty() || !is_coordinate(name) ? of_all : of_lengths);
  }
}

}  // namespace decid::recording
