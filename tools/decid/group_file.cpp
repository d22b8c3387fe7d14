// Groups of recordings: see group_file.hpp.
#include "tools/decid/group_file.hpp"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <optional>

#include "base/error.hpp"
#include "base/text.hpp"
#include "identify/study/plan_groups.hpp"
#include "identify/study/sheet.hpp"
#include "identify/study/spreadsheet.hpp"
#include "recording/table/cells.hpp"
#include "tools/decid/ranks.hpp"

namespace decid::tools {
namespace {

using Cells = std::vector<std::string>;

std::string trimmed(const std::string& text) {
  return std::string(recording::trim(text));
}

std::string lower_case(std::string text) {
  std::ranges::transform(text, text.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c; });
  return text;
}

/// Returns true if `path` ends with the parts of `end`.
bool ends_with(const std::filesystem::path& path, const std::filesystem::path& end) {
  const auto from = end.lexically_normal(), of = path.lexically_normal();
  const auto parts = std::distance(from.begin(), from.end()), all = std::distance(of.begin(), of.end());
  return parts <= all && std::equal(from.begin(), from.end(), std::next(of.begin(), all - parts));
}

struct Table {
  std::size_t file, group;                 ///< columns
  std::optional<std::size_t> participant;  ///< column
  std::vector<Cells> rows;                 ///< the first has the names
};

std::optional<std::size_t> find_column(const Cells& names, const std::string& wanted) {
  for (std::size_t i = 0; i < names.size(); ++i)
    if (lower_case(trimmed(names[i])) == wanted) return i;
  return {};
}

std::size_t require_column(const std::string& file, const Cells& names, const std::string& wanted) {
  if (const std::optional<std::size_t> found = find_column(names, wanted)) return *found;
  throw Error(Code::column_missing, file + ", line 1", "has no column \"" + wanted + "\"",
              "give a table with the columns file and group, and participant_id if some recordings are of one person");
}

std::optional<std::size_t> find_participant_column(const std::string& file, const Cells& names) {
  std::optional<std::size_t> column;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!names_participants(names[i])) continue;
    if (column)
      throw Error(Code::column_ambiguous, file + ", line 1",
                  "has two columns that may name the person, \"" + trimmed(names[*column]) + "\" and \"" +
                      trimmed(names[i]) + "\"",
                  "rename one of them");
    column = i;
  }
  return column;
}

Table read_table(const std::string& name) {
  Table table{0, 0, {}, read_spreadsheet(name)};
  const Cells& names = table.rows.front();
  table.file = require_column(name, names, "file");
  table.group = require_column(name, names, "group");
  table.participant = find_participant_column(name, names);
  return table;
}

/// A line's cells.
struct Row {
  std::string file, group, participant;
};

/// `where` names the line.
Row read_row(const Table& table, const Cells& cells, const std::string& where) {
  if (cells.size() <= std::max({table.file, table.group, table.participant.value_or(0)}))
    throw Error(Code::value_missing, where, "is too short",
                table.participant ? "give file, group and " + trimmed(table.rows.front()[*table.participant])
                                  : "give file and group");
  Row row{trimmed(cells[table.file]), trimmed(cells[table.group]), {}};
  if (has_no_value(row.group)) row.group.clear();
  if (row.file.empty()) throw Error(Code::value_missing, where, "names no file", "give one, or take the line away");
  if (table.participant && !has_no_value(cells[*table.participant]))
    row.participant = trimmed(cells[*table.participant]);
  if (table.participant && row.participant.empty() && !row.group.empty())
    throw Error(Code::value_missing, where, "has no " + trimmed(table.rows.front()[*table.participant]),
                "say whose recording it is, or leave its group empty too");
  return row;
}

/// `kind` names the column.
void refuse_contradiction(const std::string& where, const std::string& recording, const std::string& kind,
                          const std::string& before, const std::string& now) {
  if (before == now) return;
  throw Error(Code::value_invalid, where,
              recording + " has the " + kind + " \"" + before + "\" already, and now \"" + now + "\"",
              "give each recording one " + kind +
                  "; put the folder before the file's name to distinguish two files of the same name");
}

void refuse_missing(const std::string& table, const std::vector<std::string>& recordings,
                    const std::vector<std::optional<GroupMember>>& found) {
  const auto is_missing = [](const auto& member) { return !member.has_value(); };
  const auto missing = std::ranges::find_if(found, is_missing);
  if (missing == found.end()) return;
  const std::string& recording = recordings[static_cast<std::size_t>(missing - found.begin())];
  throw Error(Code::value_missing, table,
              "has no line for " + recording + " (it lacks " +
                  counted(std::ranges::count_if(found, is_missing), "recording") + ")",
              "add a line for each; an empty group keeps a recording out of the comparison");
}

}  // namespace

GroupTable read_group_table(const std::string& table_name, const std::vector<std::string>& recordings,
                            std::size_t least) {
  const Table table = read_table(table_name);
  const std::string participant_column =
      table.participant ? trimmed(table.rows.front()[*table.participant]) : std::string();
  GroupTable result{participant_column, {}};
  std::vector<std::optional<GroupMember>> found(recordings.size());
  Spelling of_group, of_person;
  for (std::size_t line = 1; line < table.rows.size(); ++line) {
    const Cells& cells = table.rows[line];
    if (std::ranges::all_of(cells, [](const std::string& cell) { return trimmed(cell).empty(); })) continue;
    const std::string where = format("%s, line %zu", table_name.c_str(), line + 1);
    const Row row = read_row(table, cells, where);
    const std::string last = std::filesystem::path(row.file).filename().string();
    bool is_used = false;
    for (std::size_t i = 0; i < recordings.size(); ++i) {
      if (!recordings[i].ends_with(last) || !ends_with(recordings[i], row.file)) continue;
      is_used = true;
      const GroupMember member{of_group(row.group), table.participant ? of_person(row.participant) : recordings[i]};
      if (!found[i]) found[i] = member;
      refuse_contradiction(where, recordings[i], "group", found[i]->group, member.group);
      refuse_contradiction(where, recordings[i], participant_column, found[i]->participant, member.participant);
    }
    if (!is_used) result.unused.push_back({line + 1, row.file});
  }
  refuse_missing(table_name, recordings, found);
  for (const std::optional<GroupMember>& member : found) result.members.push_back(*member);
  refuse_groups(result.members, table_name, least);
  return result;
}

GroupTable read_groups(const GroupFlags& flags, const RecordingFlags& recordings, const RecordingPlan& plan,
                       bool quiet) {
  if (!flags.given()) return {};
  refuse_repeated(plan, "--group");
  const std::size_t least = flags.within.empty() && flags.covariates.empty() ? 2 : 1;
  const std::string& table = flags.table;
  std::error_code ignored;
  GroupTable groups;
  if (table.empty() || (plan.sheet && std::filesystem::equivalent(table, plan.sheet->file, ignored))) {
    groups = groups_of_plan(plan, !table.empty());
    refuse_groups(groups.members, table.empty() ? recordings.study : table, least, &plan);
  } else {
    groups = read_group_table(table, recordings.files, least);
  }
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
