// Finds the tables in a text file that holds several: sections of Vicon Nexus, blocks of LabChart, segments of LabVIEW.
// Not installed.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace decid::recording {

struct Section {
  std::string name;                ///< its first line, if that is one word or phrase ("Trajectories"); else empty
  std::size_t line = 1;            ///< the line of the file, from 1, at which it begins
  std::size_t begin = 0, end = 0;  ///< in the text
};

/// Returns true for a line that may be a row of the table of `row`. Its first filled cell is a number or a clock time.
/// Or both lines begin with a word ("s01,0.01,0.5"), or only `line` does and has values wherever `row` has.
bool may_follow(const std::vector<std::string_view>& line, const std::vector<std::string_view>& row);

/// Returns the sections of a text. A section begins at the first line. After three or more rows (20, if they begin with
/// a word) it begins at a line of words after a blank line, at a repeated first header, or at LabChart's "Interval=".
/// Lines of words after the last table are a footer and belong to no section.
std::vector<Section> find_sections(std::string_view text);

/// Returns "1 'Devices' (from line 1), 2 'Trajectories' (from line 20007)".
std::string to_list(const std::vector<Section>& sections);

/// Returns the text with blank lines instead of all sections except the chosen one, so that its lines keep their
/// numbers. `section`: a name, in any case, or a number from 1. Throws Error for no section or several of that name;
/// `where` names the file.
std::string only_section(std::string_view text, const std::string& section, const std::string& where);

}  // namespace decid::recording
