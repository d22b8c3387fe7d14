// Units that a file states above its table, for columns without a unit in their names. Not installed.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace decid::recording {

struct StatedUnit {
  std::string unit;        ///< as in the file: "Centimeters"
  bool is_length = false;  ///< of lengths only: Motive's "Length Units"
};

/// Adds the unit that one line states: "Units,cm", "# unit: deg", "Length Units,Centimeters". Only a known unit of an
/// angle, a length or another quantity counts, and only alone: "Units,s,deg" is a row of units.
void add_stated_unit(std::string_view line, std::vector<StatedUnit>& units);

/// Appends the stated unit to the names without one, "COM_x" -> "COM_x (cm)", except for times, counts of samples and
/// names of other quantities. A unit of lengths belongs to coordinates ("X", "Hip Position X") only. Several different
/// units for all columns contradict each other, and none is used.
void add_units(const std::vector<StatedUnit>& units, std::vector<std::string>& names);

}  // namespace decid::recording
