// Which group each recording belongs to: a table that somebody keeps in a spreadsheet.
#pragma once

#include <string>
#include <vector>

#include "tools/decid/options.hpp"

namespace decid::tools {

/// The group of each recording, by a CSV file (RFC 4180; comma, semicolon or tab) with the columns "file" and "group"
/// and any others. A line is of the recordings whose path ends with its file: "trial.csv" is that of any folder,
/// "patients/trial.csv" of one. An empty group keeps a recording out of the comparison. Throws Error, with the line,
/// for a table without these columns, for two lines that give a recording different groups, for a recording without a
/// line, and for fewer than two groups.
std::vector<std::string> groups_of(const std::string& table, const std::vector<std::string>& recordings);

/// --group, of the commands that compare groups.
void add_group_option(const Command& command, std::string& table);

}  // namespace decid::tools
