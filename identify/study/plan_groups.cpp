// Groups of a plan: see plan_groups.hpp.
#include "identify/study/plan_groups.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <sstream>

#include "base/error.hpp"
#include "base/name_order.hpp"
#include "base/setting.hpp"
#include "base/text.hpp"
#include "identify/study/detail/contradictions.hpp"
#include "identify/study/detail/text_key.hpp"
#include "recording/table/cells.hpp"

namespace decid {
namespace {

constexpr std::array unknown_codes{-9.0, -99.0, -999.0, -9999.0, 999.0, 9999.0};

/// Throws if a few people are in both groups: a comparison in pairs leaves out everyone else.
void refuse_few_pairs(const std::string& where, const std::string& one,
                      const std::set<std::string>& participants_of_one, const std::string& other,
                      const std::set<std::string>& participants_of_other) {
  std::vector<std::string> both;
  std::ranges::set_intersection(participants_of_one, participants_of_other, std::back_inserter(both));
  if (both.empty() || 2 * both.size() >= std::min(participants_of_one.size(), participants_of_other.size())) return;
  const std::size_t all = participants_of_one.size() + participants_of_other.size() - both.size();
  throw Error(Code::value_invalid, where,
              "has " + both.front() + " in both \"" + one + "\" and \"" + other + "\", but " +
                  format("%zu of %zu people in only one of them", all - both.size(), all),
              "give different people different names, or all people recordings in both groups");
}

void refuse_without_groups(const StudySheet& sheet) {
  if (sheet.names.empty() || std::ranges::any_of(sheet.names, names_groups)) return;
  throw Error(Code::column_missing, sheet.file.string(),
              "has no column \"group\"; its columns are " + joined(sheet.names, ", ", one_line),
              "name the column of the groups so");
}

/// Throws Error if only some lines name a person: the others' recordings would be people of their own, or in no group.
void refuse_nameless(const RecordingPlan& plan) {
  const std::set<std::size_t> numbers(plan.nameless.begin(), plan.nameless.end());
  if (numbers.empty()) return;
  constexpr std::size_t shown = 10;
  std::vector<std::string> texts;
  for (const std::size_t number : numbers)
    if (texts.size() < shown) texts.push_back(std::to_string(number));
  const std::string others = numbers.size() > shown ? format(" and %zu others", numbers.size() - shown) : std::string();
  throw Error(
      Code::value_missing,
      plan.sheet->file.string() + (numbers.size() == 1 ? ", line " : ", lines ") + joined(texts, ", ") + others,
      (numbers.size() == 1 ? "has no " : "have no ") + plan.sheet->participant_column + ", and other lines have one",
      repeat_the_name);
}

/// Throws Error if commas stand between thousands: read as decimals, "12,300" steps would be fewer than 980.
void refuse_thousands(const std::vector<std::string>& cells, const std::string& where, const std::string& column) {
  recording::CommaFinder finder;
  for (const std::string& cell : cells)
    if (finder.see(cell)) break;
  if (!finder.example().empty() && finder.found(false, false) == recording::Commas::thousands)
    throw Error(Code::value_invalid, where,
                "column " + column + " has '" + std::string(finder.example()) +
                    "', whose comma may stand between thousands, beside numbers without a comma",
                "write its numbers without separators between thousands, and with decimal points");
}

/// Throws Error if compared recordings have two labels of a column that differ, but are one value in the order of
/// names: 01 and 1, 5.3.2024 and 2024-03-05.
void refuse_two_labels(const RecordingPlan& plan, const GroupTable& groups, std::string GroupMember::*label,
                       const std::string& column) {
  std::map<std::string, std::size_t> first;  // recordings of each label
  for (std::size_t i = 0; i < groups.members.size(); ++i) {
    const std::string& here = groups.members[i].*label;
    if (groups.members[i].group.empty() || here.empty() || !first.try_emplace(here, i).second) continue;
    for (const auto& [other, place] : first) {
      if (other == here || !are_equal_in_order(text_key(other), text_key(here))) continue;
      const auto where = [&](std::size_t at) {
        const PlannedRecording& it = plan.recordings[at];
        return it.line.empty() ? it.source.name() : it.line;
      };
      throw Error(Code::value_invalid, where(i),
                  "has the " + column + " \"" + here + "\", and " + where(place) + " has \"" + other +
                      "\", which is the same number or day",
                  "write one spelling of each " + column);
    }
  }
}

}  // namespace

const std::string& Spelling::operator()(const std::string& text) {
  return first_.try_emplace(text_key(text), text).first->second;
}

std::vector<std::string> split_columns(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');)
    if (part = recording::trim(part); !part.empty()) parts.push_back(part);
  return parts;
}

GroupTable groups_of_plan(const RecordingPlan& plan, bool by_group) {
  if (by_group && plan.sheet) refuse_without_groups(*plan.sheet);
  refuse_nameless(plan);
  const auto has_participant = [](const PlannedRecording& it) { return !it.entry.participant.empty(); };
  const bool has_column = std::ranges::any_of(plan.recordings, has_participant);
  GroupTable groups{has_column ? plan.sheet->participant_column : "", {}};
  groups.has_groups = by_group;
  if (!has_column && plan.sheet) groups.other_columns = plan.sheet->columns;
  Spelling of_group, of_participant, of_session, of_condition;
  for (const PlannedRecording& it : plan.recordings) {
    GroupMember& member = groups.members.emplace_back();
    member.group = by_group ? of_group(it.entry.group) : cohort::everyone;
    member.participant = has_participant(it) ? of_participant(it.entry.participant) : it.source.name();
    member.sheet_session = of_session(it.entry.session);
    member.sheet_condition = of_condition(it.entry.condition);
    if (member.group.empty()) member.missing = "group";
  }
  refuse_two_labels(plan, groups, &GroupMember::group, "group");
  return groups;
}

void refuse_groups(const std::vector<GroupMember>& members, const std::string& where, std::size_t min_groups,
                   const RecordingPlan* plan) {
  std::map<std::string, std::set<std::string>> groups;  // their people
  for (const GroupMember& member : members)
    if (!member.group.empty()) groups[member.group].insert(member.participant);
  if (groups.size() < min_groups && plan != nullptr)
    for (const PlannedRecording& planned : plan->recordings)
      if (planned.error) throw Error(*planned.error);
  if (groups.size() < min_groups)
    throw Error(Code::setting_out_of_range, where,
                "puts the recordings in " + counted(static_cast<long long>(groups.size()), "group"),
                min_groups > 1 ? "give two groups or more" : "give one group or more");
  for (auto one = groups.begin(); one != groups.end(); ++one)
    for (auto other = std::next(one); other != groups.end(); ++other)
      refuse_few_pairs(where, one->first, one->second, other->first, other->second);
}

std::size_t compare_within(const std::string& column, const RecordingPlan& plan, GroupTable& groups) {
  const std::string where = setting("within") + " " + column;
  if (!plan.sheet)
    throw Error(Code::setting_missing, where, "is a column of a sheet, and the call has none",
                "give the sheet of the study");
  if (column != "session" && column != "condition")
    throw Error(Code::setting_unknown, where, "is neither session nor condition",
                "give session, condition or both, and name the sheet's columns so");
  const auto from = column == "session" ? &SheetEntry::session : &SheetEntry::condition;
  const auto to = column == "session" ? &GroupMember::session : &GroupMember::condition;
  Spelling spelling;
  std::set<std::string> values;
  std::size_t left_out = 0;
  for (std::size_t i = 0; i < groups.members.size(); ++i) {
    GroupMember& member = groups.members[i];
    if (member.group.empty()) continue;
    member.*to = spelling(plan.recordings[i].entry.*from);
    if ((member.*to).empty()) {
      member.group.clear();
      member.missing = column;
      ++left_out;
    } else {
      values.insert(member.*to);
    }
  }
  refuse_two_labels(plan, groups, to, column);
  if (values.size() < 2)
    throw Error(Code::value_missing, where,
                "the compared recordings have " + counted(static_cast<long long>(values.size()), column),
                "give two or more in the sheet's column " + column +
                    (column == "session" ? ", or in folders ses-LABEL below sub-PARTICIPANT" : ""));
  return left_out;
}

std::vector<double> read_covariate(const RecordingPlan& plan, const std::string& column) {
  if (!plan.sheet)
    throw Error(Code::setting_missing, setting("covariates") + " " + column,
                "is a column of a sheet, and the call has none", "give the sheet of the study");
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> values;
  if (names_weights(column) || names_heights(column)) {
    const auto is_asked = [key = column_key(column)](const std::string& other) { return column_key(other) == key; };
    if (std::ranges::any_of(plan.sheet->columns, is_asked))
      throw Error(Code::value_invalid, setting("covariates") + " " + column,
                  std::string("names a ") + (names_weights(column) ? "weight" : "height") +
                      ", and the sheet's is another column",
                  "rename the column, or name the other one");
    const auto value = names_weights(column) ? &PlannedRecording::mass_kg : &PlannedRecording::height_m;
    for (const PlannedRecording& one : plan.recordings) values.push_back((one.*value).value_or(none));
    return values;
  }
  const auto text_of = plan.sheet->reader_for(column);
  const std::string where = plan.sheet->file.string();
  std::vector<std::string> cells;
  for (const PlannedRecording& one : plan.recordings) cells.push_back(text_of(one.entry));
  refuse_thousands(cells, where, column);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::optional<double> value = read_number(cells[i]);
    if (!value && !cells[i].empty())
      throw Error(Code::value_invalid, where,
                  "column " + column + " of " + plan.recordings[i].source.name() + " has '" + cells[i] +
                      "', which is not a number",
                  "write numbers, such as 0 and 1 for two kinds, or n/a");
    if (value && names_ages(column) && (*value < 1.0 || *value > 120.0))
      throw Error(Code::value_invalid, where,
                  "column " + column + " of " + plan.recordings[i].source.name() + " has '" + cells[i] +
                      "', which is not an age from 1 to 120 years",
                  "give ages in years, or n/a");
    values.push_back(value.value_or(none));
  }
  return values;
}

/// Refuses numbers that stand for "unknown" in other programs' tables, where they are far from all others.
void refuse_codes(const std::string& where, const std::set<double>& different) {
  std::set<double> codes, others;
  for (const double value : different) {
    const bool is_code = std::ranges::find(unknown_codes, value) != unknown_codes.end();
    (is_code ? codes : others).insert(value);
  }
  if (others.empty()) return;
  const double low = *others.begin(), high = *others.rbegin();
  const double far = std::max(high - low, 0.5 * std::max(std::abs(low), std::abs(high)));
  for (const double code : codes)
    if (code > high + far || code < low - far)
      throw Error(
          Code::value_invalid, where,
          format("%.0f is far from all other values, %g to %g, and often stands for an unknown one", code, low, high),
          "write n/a in the sheet for what is unknown");
}

/// Refuses what the model of groups cannot tell: it has one value per person and visit, and compares people of a cell.
void refuse_covariate(const std::string& column, std::span<const GroupMember> members) {
  const std::string where = setting("covariates") + " " + column;
  std::set<double> different;
  std::map<std::pair<std::string, std::string>, std::set<double>> of_visit;
  std::map<std::string, std::set<double>> of_cell, of_group;
  for (const GroupMember& member : members) {
    if (member.group.empty()) continue;
    std::set<double>& group = of_group[member.group];
    const double value = member.covariates.back();
    if (std::isnan(value)) continue;
    different.insert(value);
    group.insert(value);
    of_cell[member.cell()].insert(value);
    of_visit[{member.participant, member.cell()}].insert(value);
  }
  if (different.size() < 2)
    throw Error(Code::value_missing, where, "the compared recordings have fewer than two different values",
                "leave it out");
  refuse_codes(where, different);
  for (const auto& [visit, values] : of_visit)
    if (values.size() > 1)
      throw Error(Code::value_invalid, where,
                  "participant " + visit.first + " has " + std::to_string(values.size()) +
                      " values in recordings that are not compared with each other",
                  "give one value for each person and visit, or compare these recordings with " + setting("within"));
  for (const auto& [group, values] : of_group)
    if (values.empty())
      throw Error(Code::value_missing, where, "no recording of group " + group + " has a value",
                  "give its values, or leave it out");
  if (std::ranges::all_of(of_cell, [](const auto& cell) { return cell.second.size() < 2; }))
    throw Error(Code::value_invalid, where,
                "each group, session and condition that is compared has one value, so its effect and their "
                "differences are the same",
                "leave it out");
}

void add_covariate(const std::string& column, const RecordingPlan& plan, GroupTable& groups) {
  const std::vector<double> values = read_covariate(plan, column);
  for (std::size_t i = 0; i < values.size(); ++i) groups.members[i].covariates.push_back(values[i]);
  groups.covariates.push_back(column);
  refuse_covariate(column, groups.members);
}

void refuse_joint_cells(const GroupTable& groups, std::span<const FitGroup> joint) {
  if (groups.members.empty()) return;
  for (const FitGroup& group : joint) {
    std::set<std::string> cells, participants;
    for (const std::size_t i : group.recordings) {
      const GroupMember& member = groups.members.at(i);
      if (member.cell().empty()) continue;
      cells.insert(member.cell());
      participants.insert(member.participant);
    }
    if (participants.size() > 1)
      throw Error(Code::setting_conflict, setting("joint"),
                  "fits recordings of \"" + *participants.begin() + "\" and \"" + *std::next(participants.begin()) +
                      "\" together, who count as two people of a group",
                  "fit together by a column of the sheet that differs between people, such as participant_id");
    if (cells.size() > 1)
      throw Error(Code::setting_conflict, setting("joint"),
                  "fits recordings of \"" + *cells.begin() + "\" and \"" + *std::next(cells.begin()) +
                      "\" together, which the call compares",
                  "fit together by a column of the sheet with another text for each of them");
  }
}

}  // namespace decid
