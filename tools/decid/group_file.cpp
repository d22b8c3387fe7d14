// Groups of recordings: see group_file.hpp.
#include "tools/decid/group_file.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <iostream>
#include <set>

#include "base/error.hpp"
#include "base/text.hpp"
#include "identify/study/plan_groups.hpp"
#include "identify/study/sheet.hpp"
#include "tools/decid/ranks.hpp"

namespace decid::tools {
GroupTable read_group_table(const std::string& table, const std::vector<RecordingSource>& recordings,
                            std::size_t min_groups) {
  StudySheet sheet = read_sheet(table);
  const std::string column = sheet.participant_column;
  const auto group_column =
      sheet.group_column.empty()
          ? sheet.names.size()
          : static_cast<std::size_t>(std::ranges::find(sheet.names, sheet.group_column) - sheet.names.begin());
  Spelling of_group, of_participant;
  std::set<std::array<std::string, 4>> said;
  std::vector<SheetLine> lines;  // without what they say of bodies and reading
  for (const SheetLine& line : sheet.lines) {
    const SheetEntry& entry = line.entry;
    if (line.misfit) throw Error(*line.misfit);
    if (group_column < sheet.names.size() && line.cells <= group_column)
      throw Error(
          Code::value_missing, sheet.locate(line), "is too short",
          "give its " + sheet.names[group_column] + ", or an empty cell to keep the recording out of the comparison");
    if (!column.empty() && entry.participant.empty() && !entry.group.empty())
      throw Error(Code::value_missing, sheet.locate(line), "has no " + column,
                  "say whose recording it is, or leave its group empty too");
    if (said.insert({line.file, entry.session, of_group(entry.group), of_participant(entry.participant)}).second) {
      SheetLine& kept = lines.emplace_back();
      kept.number = line.number;
      kept.file = line.file;
      kept.entry = entry;
    }
  }
  sheet.lines = std::move(lines);
  const RecordingPlan plan = make_plan(std::move(sheet), recordings, Choice::for_groups, {});
  GroupTable groups = groups_of_plan(plan, true);
  groups.participant_column = column;
  for (std::size_t i = 0; i < plan.recordings.size(); ++i) {
    const PlannedRecording& planned = plan.recordings[i];
    if (planned.error) throw Error(*planned.error);
    if (!column.empty() && planned.entry.participant.empty()) groups.members[i].participant.clear();
  }
  for (const std::size_t place : plan.unused) {
    const SheetLine& line = plan.sheet->lines[place];
    groups.unused.push_back({line.number, line.file.empty() ? line.entry.participant : line.file});
  }
  refuse_groups(groups.members, table, min_groups);
  return groups;
}

namespace {

/// Returns a note on recordings in no group, with a person who has a group in another line; empty if there are none.
std::string note_on_groupless(const RecordingPlan& plan, const GroupTable& groups) {
  long long count = 0;
  std::string person;
  for (std::size_t i = 0; i < groups.members.size(); ++i) {
    const GroupMember& one = groups.members[i];
    if (!one.group.empty() || plan.recordings.at(i).error) continue;
    ++count;
    if (person.empty() && std::ranges::any_of(groups.members, [&](const GroupMember& other) {
          return !other.group.empty() && !one.participant.empty() && other.participant == one.participant;
        }))
      person = one.participant;
  }
  if (count == 0) return "";
  std::string note = "without a group, and so not compared: " + counted(count, "recording");
  if (!person.empty())
    note += "; " + one_line(person) + " has a group in another line: repeat it in each line if cells were merged";
  return note;
}

}  // namespace

GroupTable read_groups(const GroupFlags& flags, const RecordingFlags& recordings, const RecordingPlan& plan,
                       bool quiet) {
  if (!flags.given()) return {};
  refuse_repeated(plan, !flags.table.empty() ? "--group" : !flags.within.empty() ? "--within" : "--covariates");
  const std::size_t min_groups = flags.within.empty() && flags.covariates.empty() ? 2 : 1;
  const std::string& table = flags.table;
  std::error_code ignored;
  GroupTable groups;
  if (table.empty() || (plan.sheet && std::filesystem::equivalent(table, plan.sheet->file, ignored))) {
    groups = groups_of_plan(plan, !table.empty());
    refuse_groups(groups.members, table.empty() ? recordings.study : table, min_groups, &plan);
  } else {
    groups = read_group_table(table, recordings.sources, min_groups);
  }
  if (const std::string note = note_on_groupless(plan, groups); !note.empty() && !quiet && is_root())
    std::cerr << "note: " << note << '\n';
  for (const std::string& column : split_columns(flags.within)) {
    const std::size_t left_out = compare_within(column, plan, groups);
    if (left_out > 0 && !quiet && is_root())
      std::cerr << "note: without a " << column
                << ", and so not compared: " << counted(static_cast<long long>(left_out), "recording") << '\n';
  }
  for (const std::string& column : split_columns(flags.covariates)) add_covariate(column, plan, groups);
  for (const UnusedLine& unused : groups.unused)
    if (!quiet && is_root())
      std::cerr << format("note: %s, line %zu: no recording is called %s\n", table.c_str(), unused.line,
                          one_line(unused.file).c_str());
  return groups;
}

void add_group_options(const Command& command, GroupFlags& flags) {
  command.section("Input");
  command.add_option("--group", flags.table,
                     "Compare the groups of people in this CSV table: columns file, group and, if people have several "
                     "recordings, participant_id");
  command
      .add_option("--within", flags.within,
                  "Compare the sessions, the conditions or both (session,condition) of the --study sheet within each "
                  "person; with --group, also compare how much the groups change")
      .shown_as("COLUMN,..");
  command
      .add_option("--covariates", flags.covariates,
                  "Estimate how parameters change with these numeric columns of the --study sheet, such as age,weight, "
                  "and compare the groups at the columns' means")
      .shown_as("COLUMN,..");
}

}  // namespace decid::tools
