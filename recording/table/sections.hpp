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
  std::size_t line = 1;            ///< of the file, from 1, where it begins
  std::size_t begin = 0, end = 0;  ///< in the text
};

/// Returns true for a line that may be a row of the table that has `row`. Its first filled cell is a number or a clock
/// time; or both begin with a word ("s01,0.01,0.5"), or only the line does and has values wherever the row has them.
bool may_follow(const std::vector<std::string_view>& line, const std::vector<std::string_view>& row);

/// Returns the sections of a text. A section begins at the first line, and, after three or more rows (20, if they begin
/// with a word), at a line of words behind a blank line, at one of the first header again, or at LabChart's
/// "Interval=". Lines of words behind the last table are a footer and belong to no section.
std::vector<Section> find_sections(std::string_view text);

/// Returns "1 'Devices' (from line 1), 2 'Trajectories' (from line 20007)".
std::string list_of(const std::vector<Section>& sections);

/// Returns the text with blank lines in place of all sections except the chosen one, so that its lines keep their
/// numbers. `section`: a name, in any case, or a number from 1. Throws Error if there is none or several of that name;
/// `where` names the file.
std::string only_section(std::string_view text, const std::string& section, const std::string& where);

}  // namespace decid::recording
