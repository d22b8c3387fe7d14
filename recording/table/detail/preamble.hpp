// Text above the table in a text file: who, when, at which rate. Not installed.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recording/detail/stated_rate.hpp"
#include "recording/detail/stated_unit.hpp"
#include "recording/recording.hpp"
#include "recording/table/detail/misfit_header.hpp"

namespace decid::recording {

struct Preamble {
  std::size_t lines = 0;                ///< the number of lines above the table, from the file's first
  std::vector<StatedRate> rates = {};   ///< the sample rates that these lines state
  std::vector<StatedUnit> units = {};   ///< the units that these lines state
  std::optional<Unit> unit = {};        ///< of angles without a unit in their names: OpenSim's "inDegrees=no"
  std::vector<std::string> names = {};  ///< of the columns, where the format has them in several lines; else empty
  Misfit misfit = {};                   ///< a header above the table that does not fit
};

/// Finds the lines above a table's header. The table begins where consecutive lines have equally many cells, half of
/// which are numbers or clock times. Lines just above it with as many cells are its header (and its units). Exports of
/// motion capture state who, when and at which rate above ("Frequency: 100").
/// There is no preamble if the first line names a time and has as many cells as the table, or for a single column whose
/// name has no unit of angles. There is none without a table, or if lines above hold numbers like it: a damaged row
/// must not become a preamble. Combines headers of several rows (header_rows.hpp). Combines both header lines of TRC
/// files (OpenSim, Cortex: PathFileType), with the unit: "C7 X (mm)".
Preamble find_preamble(std::string_view text);

/// Returns the first `lines` lines as the preamble, and the rows below of a header of several rows. The last unit that
/// they state counts.
Preamble preamble_behind(std::string_view text, std::size_t lines);

}  // namespace decid::recording
