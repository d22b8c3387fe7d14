// What stands above the table in a text file: who, when, at which rate. Not installed.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "recording/recording.hpp"
#include "recording/stated_rate.hpp"
#include "recording/table/misfit_header.hpp"

namespace decid::recording {

struct Preamble {
  std::size_t lines = 0;                ///< of the file, from its first one, that are not the table's
  std::vector<StatedRate> rates = {};   ///< the sample rates that they state
  std::optional<Unit> unit = {};        ///< of angles without one in their names: OpenSim's "inDegrees=no"
  std::vector<std::string> names = {};  ///< of the columns, where the format has them in several lines; else empty
  Misfit misfit = {};                   ///< a header above the table that is not its own
};

/// The lines above a table's header. The table begins where lines of as many cells follow each other of which half are
/// numbers or clock times; the lines just above it with as many cells are its header (and its units). Exports of motion
/// capture say there who, when and at which rate ("Frequency: 100"). A file whose first line has as many cells as its
/// table and names a time has none, nor has one of a single column whose name has no unit of angles; neither has one in
/// which no table is found, or whose lines above it hold numbers like it: a damaged row is not to be taken for a
/// preamble. Headers of several rows are put together (header_rows.hpp). Of TRC files (OpenSim, Cortex: PathFileType)
/// the names are made of both lines of their header, with the unit: "C7 X (mm)".
Preamble find_preamble(std::string_view text);

/// Returns the preamble if it is the first `lines` lines, and the rows of a header of several below them. The last unit
/// that they state counts.
Preamble preamble_behind(std::string_view text, std::size_t lines);

}  // namespace decid::recording
