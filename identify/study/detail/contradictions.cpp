// Contradictions of a sheet: see contradictions.hpp.
#include "identify/study/detail/contradictions.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "base/text.hpp"
#include "identify/study/detail/text_key.hpp"

namespace decid {
namespace {

/// Numbers that a line gives for a person, and their text for people.
struct Stated {
  std::vector<double> numbers;
  std::string text;
};

bool differ(const Stated& a, const Stated& b) {
  // A centimetre is a hundredth of a metre, and an inch 0.0254 m, except for rounding.
  return !std::ranges::equal(a.numbers, b.numbers, [](double one, double other) {
    return std::abs(one - other) <= 1e-9 * std::max(std::abs(one), std::abs(other));
  });
}

/// The numbers of each recording of a plan, in their order; empty: none.
using AllStated = std::vector<std::optional<Stated>>;

AllStated stated_by(const RecordingPlan& plan, std::optional<Stated> (*of)(const PlannedRecording& planned)) {
  AllStated all;
  for (const PlannedRecording& planned : plan.recordings) all.push_back(of(planned));
  return all;
}

std::optional<Stated> body_of(const PlannedRecording& planned) {
  if (planned.is_body_of_other_line || !planned.mass_kg || !planned.height_m) return std::nullopt;
  return Stated{{*planned.mass_kg, *planned.height_m}, format("%g kg and %g m", *planned.mass_kg, *planned.height_m)};
}

std::string option_of(const PlannedRecording& planned, const std::string& name) {
  const auto found = std::ranges::find(planned.options, name, &std::pair<std::string, std::string>::first);
  return found == planned.options.end() ? std::string() : found->second;
}

std::optional<Stated> marker_of(const PlannedRecording& planned) {
  const std::optional<double> height_m = read_number(option_of(planned, "com_height"));
  if (!height_m) return std::nullopt;
  return Stated{{*height_m}, format("a com_height of %g m", *height_m)};
}

/// Returns the cell of a column that is carried along. column: its place in the sheet.
std::string cell_of(const PlannedRecording& planned, std::size_t column) {
  return column < planned.entry.cells.size() ? planned.entry.cells[column] : std::string();
}

/// Returns what the age's column says. age: its place in the sheet.
AllStated ages_of(const RecordingPlan& plan, std::size_t age) {
  AllStated all;
  for (const PlannedRecording& planned : plan.recordings) {
    const std::string text = cell_of(planned, age);
    const std::optional<double> number = read_number(text);
    all.push_back(number ? std::make_optional(Stated{{*number}, text}) : std::nullopt);
  }
  return all;
}

/// Returns for each recording the first other one of its visit that says something else. visits: their recordings.
template <class Visits>
std::map<std::size_t, std::size_t> contradicting(const Visits& visits, const AllStated& stated) {
  std::map<std::size_t, std::size_t> found;
  for (const auto& [name, recordings] : visits)
    for (const std::size_t i : recordings) {
      const auto other = std::ranges::find_if(
          recordings, [&](std::size_t j) { return stated[i] && stated[j] && differ(*stated[i], *stated[j]); });
      if (other != recordings.end()) found[i] = *other;
    }
  return found;
}

/// Returns what the spellings of a person share: the text without "sub-", leading zeros, and blanks, hyphens and
/// underscores; of those between digits one stays, because 1-11 and 11-1 are two people.
std::string person_key(const std::string& participant) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  std::string text = text_key(without_point_zero(participant)), key;
  if (text.starts_with("sub-")) text.erase(0, 4);
  bool is_apart = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i], last = key.empty() ? ' ' : key.back();
    if (c == ' ' || c == '-' || c == '_') {
      is_apart = true;
      continue;
    }
    const bool begins_number = is_digit(c) && (is_apart || !(is_digit(last) || last == '.' || last == ','));
    if (is_apart && is_digit(c) && is_digit(last)) key += '-';
    if (begins_number && c == '0' && i + 1 < text.size() && is_digit(text[i + 1])) continue;
    key += c;
    is_apart = false;
  }
  return key;
}

/// Returns "P1 two bodies in session 2: 70 kg and 1.75 m here, 80 kg and 1.75 m for b.csv".
std::string sentence(const RecordingPlan& plan, const AllStated& stated, std::size_t i, std::size_t other,
                     const std::string& what) {
  const SheetEntry& entry = plan.recordings[i].entry;
  return "the sheet gives " + entry.participant + " two " + what +
         (entry.session.empty() ? std::string() : " in session " + entry.session) + ": " + stated[i]->text + " here, " +
         stated[other]->text + " for " + plan.recordings[other].source.name();
}

/// Adds the warning `other_bmi`. index: the place of the body mass index in the sheet.
void warn_of_other_index(PlannedRecording& planned, std::size_t index) {
  constexpr double low_kg_m2 = 10.0, high_kg_m2 = 70.0, rounding = 0.15;
  const std::optional<double> stated = read_number(cell_of(planned, index));
  if (!stated || *stated < low_kg_m2 || *stated > high_kg_m2 || !body_of(planned)) return;
  const double mass_kg = *planned.mass_kg, height_m = *planned.height_m, of_body = mass_kg / (height_m * height_m);
  if (std::abs(of_body - *stated) <= rounding * of_body) return;
  add_caution(planned.warnings, "other_bmi",
              format("the sheet gives a body mass index of %g kg/m2, and a weight of %g kg and a height of %g m, whose "
                     "index is %.1f kg/m2: check which of them is wrong",
                     *stated, mass_kg, height_m, of_body));
}

}  // namespace

void refuse_two_groups(const StudySheet& sheet) {
  std::map<std::string, const SheetLine*> first;  // of each person, with a group
  for (const SheetLine& line : sheet.lines) {
    const SheetEntry& entry = line.entry;
    if (entry.participant.empty() || entry.group.empty()) continue;
    const SheetLine& before = *first.try_emplace(text_key(entry.participant), &line).first->second;
    if (text_key(before.entry.group) == text_key(entry.group)) continue;
    throw Error(
        Code::value_invalid, format("%s, lines %zu and %zu", sheet.file.string().c_str(), before.number, line.number),
        "put " + entry.participant + " in the groups \"" + before.entry.group + "\" and \"" + entry.group + "\"",
        "give different people different names, and a person one group; name what differs between a person's "
        "recordings as a session or a condition");
  }
}

void refuse_two_spellings(const StudySheet& sheet) {
  std::map<std::string, const SheetLine*> first;  // of each person
  for (const SheetLine& line : sheet.lines) {
    const std::string& here = line.entry.participant;
    if (here.empty()) continue;
    const SheetLine& before = *first.try_emplace(person_key(here), &line).first->second;
    const std::string& there = before.entry.participant;
    if (text_key(there) == text_key(here)) continue;
    throw Error(
        Code::value_invalid, format("%s, lines %zu and %zu", sheet.file.string().c_str(), before.number, line.number),
        "name a person \"" + there + "\" and \"" + here + "\"",
        "write one spelling in all lines, or give two people names that differ in more than zeros, blanks and hyphens");
  }
}

void warn_of_contradictions(RecordingPlan& plan) {
  using Visit = std::vector<std::string>;  // person and session; of a marker also the column that it is in
  std::map<Visit, std::vector<std::size_t>> visits, of_column;
  for (std::size_t i = 0; i < plan.recordings.size(); ++i) {
    const PlannedRecording& planned = plan.recordings[i];
    if (planned.entry.participant.empty()) continue;
    const std::string participant = text_key(planned.entry.participant), session = text_key(planned.entry.session);
    visits[{participant, session}].push_back(i);
    of_column[{participant, session, text_key(option_of(planned, "column"))}].push_back(i);
  }
  const auto warnings_of = [&](std::size_t i) -> Warnings& { return plan.recordings[i].warnings; };
  const AllStated bodies = stated_by(plan, body_of), markers = stated_by(plan, marker_of);
  const std::map<std::size_t, std::size_t> other_body = contradicting(visits, bodies);
  for (const auto& [i, other] : other_body) {
    Warnings& warnings = warnings_of(i);
    add_caution(warnings, "two_bodies", sentence(plan, bodies, i, other, "bodies"));
  }
  for (const auto& [i, other] : contradicting(of_column, markers)) {
    Warnings& warnings = warnings_of(i);
    if (!other_body.contains(i)) add_caution(warnings, "two_bodies", sentence(plan, markers, i, other, "bodies"));
  }
  const std::vector<std::string>& columns = plan.sheet->columns;
  const auto index = std::ranges::find_if(columns, names_body_mass_indices);
  if (index != columns.end())
    for (PlannedRecording& planned : plan.recordings)
      warn_of_other_index(planned, static_cast<std::size_t>(index - columns.begin()));
  const auto age = std::ranges::find_if(columns, names_ages);
  if (age == columns.end()) return;
  const AllStated ages = ages_of(plan, static_cast<std::size_t>(age - columns.begin()));
  for (const auto& [i, other] : contradicting(visits, ages)) {
    Warnings& warnings = warnings_of(i);
    add_caution(warnings, "two_ages", sentence(plan, ages, i, other, "ages"));
  }
}

}  // namespace decid
