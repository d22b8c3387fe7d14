// Notes on sessions and conditions: see visit_notes.hpp.
#include "tools/report/json/visit_notes.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "base/name_order.hpp"
#include "base/setting.hpp"
#include "base/text.hpp"

namespace decid::tools {
namespace {

using Counts = std::map<std::string, std::size_t, NameOrder>;

/// Returns true if the values differ between groups: one lacks a value, or their shares differ by more than a fifth.
bool differ(const std::map<std::string, Counts, NameOrder>& groups) {
  Counts all;
  for (const auto& [name, counts] : groups)
    for (const auto& [value, count] : counts) all[value] += count;
  for (const auto& [value, whole] : all) {
    double low = 1.0, high = 0.0;
    for (const auto& [name, counts] : groups) {
      double total = 0.0;
      for (const auto& [other, count] : counts) total += static_cast<double>(count);
      const auto found = counts.find(value);
      if (found == counts.end()) return true;
      low = std::min(low, static_cast<double>(found->second) / total);
      high = std::max(high, static_cast<double>(found->second) / total);
    }
    if (high - low > 0.2) return true;
  }
  return false;
}

/// Returns the first elements of a map as text, "a, b, ...".
template <class Map, class TextOf>
std::string first_of(const Map& map, const char* separator, TextOf text_of) {
  constexpr std::size_t max_shown = 6;
  std::string text;
  std::size_t shown = 0;
  for (const auto& [name, value] : map) {
    if (shown > 0) text += separator;
    if (shown == max_shown) return text + "...";
    text += text_of(name, value);
    ++shown;
  }
  return text;
}

/// Returns true if more than half of the values, three or more, are of one person each.
bool most_are_of_one_person(const std::map<std::string, std::set<std::string>, NameOrder>& people_of) {
  const auto alone = std::ranges::count_if(people_of, [](const auto& one) { return one.second.size() == 1; });
  return people_of.size() > 2 && 2 * static_cast<std::size_t>(alone) > people_of.size();
}

}  // namespace

std::vector<std::string> notes_on_mixed(const GroupReport& groups, bool has_study) {
  std::vector<std::string> notes;
  const std::vector<GroupMember>& members = groups.table.members;
  const auto is_compared = [&](std::string GroupMember::*value) {
    return std::ranges::any_of(members, [&](const GroupMember& one) { return !(one.*value).empty(); });
  };
  const auto add = [&](const std::string& column, std::string GroupMember::*compared, std::string GroupMember::*stated,
                       const std::string& other) {
    if (is_compared(compared)) return;
    std::map<std::string, Counts, NameOrder> of_groups;
    std::map<std::string, std::set<std::string>, NameOrder> people_of;
    for (std::size_t i = 0; i < members.size(); ++i) {
      const std::string group = members[i].cell();
      const auto place = std::ranges::find(groups.comparison.groups, group, &Group::name);
      if (group.empty() || !groups.left_out[i].empty() || place == groups.comparison.groups.end()) continue;
      if (std::ranges::find(groups.comparison.too_small,
                            static_cast<std::size_t>(place - groups.comparison.groups.begin())) !=
          groups.comparison.too_small.end())
        continue;
      const std::string value = (members[i].*stated).empty() ? "n/a" : members[i].*stated;
      ++of_groups[group][value];
      people_of[value].insert(members[i].participant);
    }
    if (of_groups.size() < 2 || most_are_of_one_person(people_of) || !differ(of_groups)) return;
    const std::string shown = first_of(of_groups, "; ", [](const std::string& group, const Counts& counts) {
      return one_line(group) + ": " + first_of(counts, ", ", [](const std::string& value, std::size_t count) {
               return format("%zu of %s", count, one_line(value).c_str());
             });
    });
    const std::string sheet = has_study ? "" : "give the table as " + setting("study") + ", and ";
    notes.push_back("The groups have different " + column + "s (recordings of " + shown +
                    "), so their differences may be those of " + column + "s: compare these too (" + sheet +
                    setting("within") + " " + other + column + "), or leave recordings out.");
  };
  add("session", &GroupMember::session, &GroupMember::sheet_session, "");
  add("condition", &GroupMember::condition, &GroupMember::sheet_condition,
      is_compared(&GroupMember::session) ? "session," : "");
  return notes;
}

bool has_one_person(const GroupReport& groups) {
  std::set<std::string> people;
  for (std::size_t i = 0; i < groups.table.members.size(); ++i)
    if (const GroupMember& one = groups.table.members[i]; !one.group.empty() && groups.left_out[i].empty())
      people.insert(one.participant);
  return people.size() == 1;
}

std::vector<std::string> notes_on_lone_sessions(const GroupReport& groups) {
  std::map<std::string, std::set<std::string>, NameOrder> people_of;
  for (std::size_t i = 0; i < groups.table.members.size(); ++i) {
    const GroupMember& one = groups.table.members[i];
    if (!one.group.empty() && !one.session.empty() && groups.left_out[i].empty())
      people_of[one.session].insert(one.participant);
  }
  if (!most_are_of_one_person(people_of) || has_one_person(groups)) return {};
  const std::string shown =
      first_of(people_of, ", ", [](const std::string& session, const auto&) { return one_line(session); });
  return {"Most sessions have one person alone (" + shown +
          "), so there is little to compare: number each person's visits (1, 2) instead of writing dates."};
}

std::vector<std::string> notes_on_dates(const GroupReport& groups) {
  std::string unclear;
  for (const GroupMember& one : groups.table.members) {
    if (one.group.empty()) continue;
    const DayMonth order = day_month_of(one.session);
    if (order == DayMonth::day_first) return {};
    if (order == DayMonth::unclear && unclear.empty()) unclear = one.session;
  }
  if (unclear.empty()) return {};
  return {"Session " + one_line(unclear) +
          " is ordered as day, month and year: write dates as 2024-03-31 if the month comes first."};
}

}  // namespace decid::tools
