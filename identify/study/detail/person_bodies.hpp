// Bodies of a sheet's people, for lines that give none: often only a person's first line does. Not installed.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/warning.hpp"
#include "identify/study/sheet.hpp"

namespace decid {

/// The weights and heights that the lines of a sheet give, by their people.
class PersonBodies {
 public:
  PersonBodies() = default;
  explicit PersonBodies(const std::vector<SheetLine>& lines);

  /// Fills the weight and the height that a line lacks from other lines of its person: from those of the same session
  /// first, then from lines above before lines below, from the nearest. Then adds the note `body_of_other_line` and
  /// returns true.
  bool fill(SheetLine& line, Warnings& warnings) const;

 private:
  struct Giver {
    std::size_t number;
    std::string session;
    std::optional<double> mass_kg, height_m;
  };
  static const Giver* find(const std::vector<Giver>& givers, const SheetLine& line,
                           std::optional<double> Giver::*quantity);

  std::map<std::string, std::vector<Giver>> givers_;  // by text_key() of the participant
};

}  // namespace decid
