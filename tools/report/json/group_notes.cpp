// Notes on the groups of a comparison: see group_notes.hpp.
#include "tools/report/json/group_notes.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <set>
#include <string_view>

#include "base/text.hpp"

namespace decid::tools {
namespace {

/// Returns how many letters differ between two texts (V. Levenshtein, Soviet Physics Doklady 10 (1966) 707-710).
std::size_t count_edits(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t changed = diagonal + (a[i - 1] == b[j - 1] ? 0U : 1U);
      diagonal = row[j];
      row[j] = std::min({changed, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

/// Returns true if a name may be a typing error of another one. Names that differ in digits are other names.
bool may_misspell(const std::string& name, const std::string& other) {
  std::string a = lower_case(name), b = lower_case(other), digits_a, digits_b;
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  std::ranges::copy_if(a, std::back_inserter(digits_a), is_digit);
  std::ranges::copy_if(b, std::back_inserter(digits_b), is_digit);
  return digits_a == digits_b && count_edits(a, b) <= std::min<std::size_t>(2, std::max(a.size(), b.size()) / 3);
}

bool is_mark_of_exclusion(const std::string& group) {
  constexpr auto marks =
      std::to_array<std::string_view>({"exclude", "excluded", "exclusion", "drop", "dropped", "dropout", "drop-out",
                                       "withdrawn", "removed", "invalid", "ignore", "skip", "ausgeschlossen"});
  return std::ranges::find(marks, lower_case(group)) != marks.end();
}

std::string quoted(const std::string& name) {
  return "'" + one_line(name) + "'";
}

/// Returns "Group 'patient' has one person: a typo of 'patients'? The comparison leaves this group out."
std::string note_on_small(const GroupComparison& found, std::size_t place, bool is_left_out) {
  const Group& small = found.groups[place];
  std::string note = small.participants == 1 ? "Group " + quoted(small.name) + " has one person"
                                             : "No recording of group " + quoted(small.name) + " can be used";
  const auto other = std::ranges::find_if(found.groups, [&](const Group& group) {
    return group.participants > small.participants && may_misspell(small.name, group.name);
  });
  note += other == found.groups.end() ? "." : ": a typo of " + quoted(other->name) + "?";
  return is_left_out ? note + " The comparison leaves this group out." : note;
}

}  // namespace

std::vector<std::string> group_notes(const Report& report) {
  std::vector<std::string> notes;
  if (!report.groups) return notes;
  const GroupTable& table = report.groups->table;
  const GroupComparison& found = report.groups->comparison;
  if (table.participant_column.empty() && !table.members.empty()) {
    std::string note = "No column names the person, so each recording counts as a person.";
    for (std::size_t i = 0; i < table.other_columns.size(); ++i)
      note += (i == 0 ? " Columns that decid carries along: " : ", ") + one_line(table.other_columns[i]);
    notes.push_back(note);
  }
  for (std::size_t place = 0; place < found.groups.size(); ++place)
    if (found.groups[place].participants < 2)
      notes.push_back(note_on_small(found, place, std::ranges::find(found.too_small, place) != found.too_small.end()));
  std::set<std::string> groups;
  for (const GroupMember& member : table.members) groups.insert(member.group);
  for (const std::string& group : groups)
    if (is_mark_of_exclusion(group))
      notes.push_back("Group " + quoted(group) +
                      " is compared as any other: leave the cell empty, or write n/a, to exclude recordings.");
  return notes;
}

}  // namespace decid::tools
