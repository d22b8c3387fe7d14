// Comparisons in sentences: see group_verdicts.hpp.
#include "tools/report/json/group_verdicts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string_view>

#include "base/name_order.hpp"
#include "base/text.hpp"
#include "identify/study/sheet.hpp"
#include "posterior/sampling/diagnostics.hpp"
#include "tools/report/json/visit_notes.hpp"

namespace decid::tools {
namespace {

/// A difference of one parameter, in SI units, and the interval that decides.
struct Decided {
  double difference;
  std::array<double, 2> interval;
};

/// The unit in which people read a parameter, and its number per SI unit.
struct PeoplesUnit {
  std::string name;
  double factor;
};
PeoplesUnit peoples_unit(const sim::ParameterInfo& info) {
  if (info.unit == "s") return {" ms", 1e3};
  if (info.unit == "rad/s") return {" deg/s", 1.0 / sim::rad_per_deg};
  return {info.unit_after(), 1.0};
}

/// Returns "delay: patients longer, 21 ms [5, 37]".
std::string shown_difference(const sim::ParameterInfo& info, const Decided& found, const std::string& first,
                             const std::string& second) {
  const PeoplesUnit unit = peoples_unit(info);
  const bool first_is_higher = found.difference > 0.0;
  const double sign = first_is_higher ? unit.factor : -unit.factor;
  double low = sign * found.interval[0], high = sign * found.interval[1];
  if (low > high) std::swap(low, high);
  return info.name + ": " + (first_is_higher ? first : second) + (info.unit == "s" ? " longer, " : " higher, ") +
         format("%.3g%s [%.3g, %.3g]", sign * found.difference, unit.name.c_str(), low, high);
}

/// Returns the parameters that differ, as shown(parameter) describes them, then the others. reason: why intervals are
/// missing.
template <class Shown>
std::string findings(const sim::ParameterTable& parameters, const std::vector<Decided>& all, const std::string& reason,
                     const Shown& shown_of) {
  std::string shown, same, unknown;
  const auto add = [](std::string& list, const char* between, const std::string& text) {
    list += (list.empty() ? "" : between) + text;
  };
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    const auto& [low, high] = all[p].interval;
    if (!std::isfinite(low) || !std::isfinite(high))
      add(unknown, ", ", parameters[p].name);
    else if (low > 0.0 || high < 0.0)
      add(shown, "; ", shown_of(p));
    else
      add(same, ", ", parameters[p].name);
  }
  if (!same.empty()) add(shown, "; ", "no difference shown in: " + same);
  if (!unknown.empty()) add(shown, "; ", "no interval of: " + unknown + " (" + reason + ")");
  return shown;
}

std::string sentence(const std::string& first, const std::string& second, const sim::ParameterTable& parameters,
                     const std::vector<Decided>& all, const std::string& reason) {
  return first + " and " + second + ": " + findings(parameters, all, reason, [&](std::size_t p) {
           return shown_difference(parameters[p], all[p], first, second);
         });
}

std::vector<Decided> decided(const std::vector<cohort::Effect>& effects) {
  std::vector<Decided> all;
  for (const cohort::Effect& effect : effects) all.push_back({effect.difference.mean, effect.simultaneous95});
  return all;
}

/// Returns a cell's name in sentences: "patients, 1", but "group 1" instead of "1". cell: a GroupMember or Cell.
template <class T>
std::string shown_name(const T& cell) {
  const std::string name = cohort::cell_name(cell.group, cell.session, cell.condition);
  if (!read_number(name)) return one_line(name);
  return (!cell.group.empty() && cell.group != cohort::everyone ? "group "
          : cell.session.empty()                                ? "condition "
                                                                : "session ") +
         name;
}

/// Returns the name in sentences of a group of the comparison.
std::string shown_group(const GroupReport& groups, std::size_t place) {
  const std::string& name = groups.comparison.groups[place].name;
  for (const GroupMember& member : groups.table.members)
    if (!member.group.empty() && member.cell() == name) return shown_name(member);
  return one_line(name);
}

/// Returns "2 minus 1, in controls and in patients: Nv: 0.012 in controls, -0.103 in patients; difference of the
/// changes 0.115 [0.03, 0.2]".
std::string interaction_sentence(const cohort::Result& found, const cohort::Interaction& one,
                                 const sim::ParameterTable& parameters) {
  const cohort::Comparison &first = found.comparisons[one.first], &second = found.comparisons[one.second];
  // Both comparisons are of one pair of labels; the other labels say where each of them is.
  const cohort::Cell &minuend = found.cells[first.first], &subtrahend = found.cells[first.second];
  std::string cohort::Cell::*compared = minuend.session != subtrahend.session       ? &cohort::Cell::session
                                        : minuend.condition != subtrahend.condition ? &cohort::Cell::condition
                                                                                    : &cohort::Cell::group;
  const auto place_of = [&](const cohort::Comparison& comparison) {
    cohort::Cell cell = found.cells[comparison.first];
    cell.*compared = compared == &cohort::Cell::group ? cohort::everyone : "";
    return shown_name(cell);
  };
  const std::string in_first = " in " + place_of(first), in_second = " in " + place_of(second);
  const std::vector<Decided> all = decided(one.effects);
  const auto shown_of = [&](std::size_t p) {
    const PeoplesUnit unit = peoples_unit(parameters[p]);
    const auto value_in = [&](const cohort::Comparison& comparison) {
      return format("%.3g%s", unit.factor * comparison.effects[p].difference.mean, unit.name.c_str());
    };
    return parameters[p].name + ": " + value_in(first) + in_first + ", " + value_in(second) + in_second +
           format("; difference of the changes %.3g%s [%.3g, %.3g]", unit.factor * all[p].difference, unit.name.c_str(),
                  unit.factor * all[p].interval[0], unit.factor * all[p].interval[1]);
  };
  return one_line(minuend.*compared) + " minus " + one_line(subtrahend.*compared) + "," + in_first + " and" +
         in_second + ": " + findings(parameters, all, "the draws give none", shown_of);
}

/// Returns the sentences of the hierarchical model.
std::vector<std::string> sentences_of(const cohort::Result& found, const sim::ParameterTable& parameters) {
  std::vector<std::string> sentences;
  const auto name = [&](std::size_t cell) { return shown_name(found.cells[cell]); };
  for (const cohort::Comparison& one : found.comparisons)
    sentences.push_back(
        sentence(name(one.first), name(one.second), parameters, decided(one.effects), "the draws give none"));
  for (const cohort::Interaction& one : found.interactions)
    sentences.push_back(interaction_sentence(found, one, parameters));
  return sentences;
}

/// Returns true if a name may be a typing error of another one. Names that differ in digits are other names.
bool may_misspell(const std::string& name, const std::string& other) {
  std::string a = lower_case(name), b = lower_case(other), digits_a, digits_b;
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  std::ranges::copy_if(a, std::back_inserter(digits_a), is_digit);
  std::ranges::copy_if(b, std::back_inserter(digits_b), is_digit);
  return digits_a == digits_b && count_edits(a, b) <= std::min<std::size_t>(2, std::max(a.size(), b.size()) / 3);
}

/// Returns the words of a name, which blanks, hyphens and underscores separate.
std::vector<std::string> words_of(const std::string& name) {
  std::vector<std::string> words(1);
  for (const char c : lower_case(name)) {
    if (c == ' ' || c == '-' || c == '_')
      words.emplace_back();
    else
      words.back() += c;
  }
  return words;
}

/// Returns true if two groups of any size may be one, misspelled. Short words such as on and off are other words, and
/// so are male and female, test and retest.
bool may_be_one(const std::string& name, const std::string& other) {
  const auto is_alike = [](const std::string& a, const std::string& b) {
    return a == b || (a.size() > 4 && may_misspell(a, b) && !a.ends_with(b) && !b.ends_with(a));
  };
  const std::vector<std::string> words = words_of(name), others = words_of(other);
  return words.size() == others.size() && std::ranges::equal(words, others, is_alike);
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

/// Returns a note for each two labels of compared recordings that may be one, misspelled, unless a note on small groups
/// names one of them.
std::vector<std::string> notes_on_spelling(const GroupReport& report, const std::set<std::string>& small) {
  std::vector<std::string> notes;
  const auto add = [&](const std::string& what, std::string GroupMember::*label) {
    std::set<std::string, NameOrder> labels;
    for (const GroupMember& member : report.table.members)
      if (!member.group.empty() && !(member.*label).empty() && !small.contains(member.*label))
        labels.insert(member.*label);
    for (auto one = labels.begin(); one != labels.end(); ++one)
      for (auto other = std::next(one); other != labels.end(); ++other)
        if (may_be_one(*one, *other))
          notes.push_back(what + " " + quoted(*one) + " and " + quoted(*other) +
                          " are compared with each other: if one is a typo of the other, correct it.");
  };
  add("Groups", &GroupMember::group);
  add("Sessions", &GroupMember::session);
  add("Conditions", &GroupMember::condition);
  return notes;
}

/// Returns notes for people, beside the verdicts: that each recording counts as a person; sessions and conditions that
/// may mislead (visit_notes.hpp); chains of the hierarchical model that disagree; groups of nobody, and groups of one
/// unless most sessions or the whole comparison have one person, with the group whose name they may misspell; labels
/// that may be one, misspelled; groups whose names are marks of exclusion.
std::vector<std::string> group_notes(const Report& report) {
  std::vector<std::string> notes;
  const GroupTable& table = report.groups->table;
  const GroupComparison& found = report.groups->comparison;
  if (table.participant_column.empty() && !table.members.empty()) {
    std::string note = "No column names the person, so each recording counts as a person.";
    for (std::size_t i = 0; i < table.other_columns.size(); ++i)
      note += (i == 0 ? " Columns that decid carries along: " : ", ") + one_line(table.other_columns[i]);
    notes.push_back(note);
  }
  if (report.groups->hierarchical && !(report.groups->hierarchical->max_rhat <= posterior::agreed_rhat))
    notes.push_back(
        format("The chains of the hierarchical model do not agree (R-hat %.2f): its intervals may be wrong.",
               report.groups->hierarchical->max_rhat));
  const auto add = [&](const std::vector<std::string>& some) { notes.insert(notes.end(), some.begin(), some.end()); };
  const std::vector<std::string> lone = notes_on_lone_sessions(*report.groups);
  add(notes_on_mixed(*report.groups, report.sheet.has_value()));
  add(notes_on_dates(*report.groups));
  add(lone);
  std::set<std::string> small;
  for (std::size_t place = 0; place < found.groups.size(); ++place) {
    const std::size_t participants = found.groups[place].participants;
    if (participants > 1 || (participants == 1 && (!lone.empty() || has_one_person(*report.groups)))) continue;
    notes.push_back(note_on_small(found, place, std::ranges::find(found.too_small, place) != found.too_small.end()));
    small.insert(found.groups[place].name);
  }
  add(notes_on_spelling(*report.groups, small));
  std::set<std::string> groups;
  for (const GroupMember& member : table.members) groups.insert(member.group);
  for (const std::string& group : groups)
    if (is_mark_of_exclusion(group))
      notes.push_back("Group " + quoted(group) +
                      " is compared as any other: leave the cell empty, or write n/a, to exclude recordings.");
  return notes;
}

}  // namespace

const char* missing_interval_reason(const GroupPair& pair) {
  return std::ranges::min(pair.participants) < 2 ? "too few people" : "identical values of all people";
}

GroupVerdicts group_verdicts(const Report& report) {
  if (!report.groups) return {};
  const sim::ParameterTable parameters = report.compared_parameters();
  if (report.groups->hierarchical)
    return {"the simultaneous intervals of the hierarchical model",
            sentences_of(*report.groups->hierarchical, parameters), group_notes(report)};
  GroupVerdicts verdicts{"the adjusted intervals", {}};
  const GroupComparison& found = report.groups->comparison;
  for (const GroupPair& pair : found.pairs) {
    std::vector<Decided> all;
    for (const GroupEffect& effect : pair.parameters) all.push_back({effect.difference, effect.adjusted_interval95});
    verdicts.sentences.push_back(sentence(shown_group(*report.groups, pair.first),
                                          shown_group(*report.groups, pair.second), parameters, all,
                                          missing_interval_reason(pair)));
  }
  if (!verdicts.sentences.empty()) verdicts.notes = group_notes(report);
  return verdicts;
}

}  // namespace decid::tools
