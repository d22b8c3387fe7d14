// Reads which group and which person each recording belongs to, from a table made with a spreadsheet.
#pragma once

#include <string>
#include <vector>

#include "identify/groups.hpp"
#include "tools/decid/options.hpp"
#include "tools/decid/recording_flags.hpp"

namespace decid::tools {

/// Reads the group and the person of each recording from a CSV file (RFC 4180; comma, semicolon or tab) with the
/// columns "file" and "group", if it has one "subject", "participant", "person" or "patient", with or without "id", and
/// any others. A line is of the recordings whose path ends with its file: "trial.csv" is that of any folder,
/// "patients/trial.csv" of one. An empty group keeps a recording out of the comparison. Throws Error, with the line,
/// for a table without these columns or with two columns of people, for two lines that contradict each other, for a
/// line with a group and no person, for a recording without a line, for fewer than two groups, and for two groups that
/// share some people, but fewer than half of the smaller one's: more likely a name given twice than a comparison in
/// pairs.
GroupTable read_group_table(const std::string& table, const std::vector<std::string>& recordings);

/// Reads the table for the recordings that were found; without a table there are no groups. If the table is the plan's
/// sheet, a recording has the group and the person of its line there. Prints on standard error which lines are of no
/// recording, unless `quiet`. Throws Error also for a recording that is given twice, under
/// whatever name: it would count as two people.
GroupTable read_groups(const std::string& table, const RecordingFlags& recordings, const RecordingPlan& plan,
                       bool quiet);

/// Adds --group, of the commands that compare groups.
void add_group_option(const Command& command, std::string& table);

}  // namespace decid::tools
