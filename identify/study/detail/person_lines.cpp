// Lines and bodies of people: see person_lines.hpp.
#include "identify/study/detail/person_lines.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

#include "base/text.hpp"
#include "identify/study/detail/text_key.hpp"

namespace decid {
namespace {

/// Keeps the lines with the clearest names.
std::vector<std::size_t> clearest(std::vector<std::size_t> lines, const std::vector<PathKey::Naming>& naming) {
  PathKey::Naming best = PathKey::Naming::none;
  for (const std::size_t line : lines) best = std::max(best, naming[line]);
  std::erase_if(lines, [&](std::size_t line) { return naming[line] != best; });
  return lines;
}

}  // namespace

PersonLines::PersonLines(const std::vector<SheetLine>& lines) {
  for (const SheetLine& line : lines)
    lines_.push_back({text_key(line.entry.participant), text_key(line.entry.session), !line.file.empty()});
}

FittingLines PersonLines::find(const PathKey& path) const {
  constexpr PathKey::Naming none = PathKey::Naming::none;
  std::vector<PathKey::Naming> participants(lines_.size(), none), sessions = participants;
  std::vector<std::size_t> named;
  for (std::size_t line = 0; line < lines_.size(); ++line) {
    if (lines_[line].is_recording) continue;
    participants[line] = path.naming_of_participant(lines_[line].participant);
    if (participants[line] == none) continue;
    sessions[line] = path.naming_of_session(lines_[line].session, lines_[line].participant);
    named.push_back(line);
  }
  // Before sessions: a folder of a person whose lines are of other sessions does not leave its files to other people.
  const std::vector<std::size_t> of_person = clearest(std::move(named), participants);
  std::vector<std::size_t> fitting = of_person;
  std::erase_if(fitting, [&](std::size_t line) { return !lines_[line].session.empty() && sessions[line] == none; });
  if (fitting.empty()) return {std::nullopt, {}, of_person};
  if (std::vector<std::size_t> two = find_unlike(fitting, &Line::participant); !two.empty())
    return {std::nullopt, std::move(two)};
  const std::vector<std::size_t> best = clearest(fitting, sessions);
  if (std::vector<std::size_t> two = find_unlike(best, &Line::session); !two.empty())
    return {std::nullopt, std::move(two)};
  return {best.front(), std::move(fitting)};
}

bool PersonLines::covers(std::size_t person, std::size_t recording) const {
  const Line &all = lines_[person], &one = lines_[recording];
  return !all.is_recording && !all.participant.empty() && all.participant == one.participant &&
         (all.session.empty() || all.session == one.session);
}

bool PersonLines::has_recording_line(std::size_t person) const {
  const std::string& participant = lines_[person].participant;
  return !participant.empty() && std::ranges::any_of(lines_, [&](const Line& line) {
    return line.is_recording && line.participant == participant;
  });
}

std::vector<std::size_t> PersonLines::find_unlike(const std::vector<std::size_t>& some, std::string Line::*text) const {
  const std::string& first = lines_[some.front()].*text;
  const auto other = std::ranges::find_if(some, [&](std::size_t line) { return lines_[line].*text != first; });
  return other == some.end() ? std::vector<std::size_t>() : std::vector<std::size_t>{some.front(), *other};
}

PersonBodies::PersonBodies(const std::vector<SheetLine>& lines) {
  for (const SheetLine& line : lines)
    if (!line.entry.participant.empty() && (line.mass_kg || line.height_m))
      givers_[text_key(line.entry.participant)].push_back(
          {line.number, line.entry.session, line.mass_kg, line.height_m});
}

const PersonBodies::Giver* PersonBodies::find(const std::vector<Giver>& givers, const SheetLine& line,
                                              std::optional<double> Giver::*quantity) {
  const std::string session = text_key(line.entry.session);
  const auto distance = [&](const Giver& giver) {
    const bool is_above = giver.number < line.number;
    return std::tuple(text_key(giver.session) != session, !is_above,
                      is_above ? line.number - giver.number : giver.number - line.number);
  };
  const Giver* nearest = nullptr;
  for (const Giver& giver : givers)
    if (giver.*quantity && (nearest == nullptr || distance(giver) < distance(*nearest))) nearest = &giver;
  return nearest;
}

Warnings PersonBodies::fill(SheetLine& line) const {
  if (line.mass_kg && line.height_m) return {};
  const auto found = givers_.find(text_key(line.entry.participant));
  if (found == givers_.end()) return {};
  std::string lacking, taken;
  const auto take = [&](std::optional<double>& value, std::optional<double> Giver::*quantity, const char* name,
                        const char* unit) {
    if (value) return;
    const Giver* const giver = find(found->second, line, quantity);
    if (giver == nullptr) return;
    value = giver->*quantity;
    lacking += (lacking.empty() ? "" : " and no ") + std::string(name);
    taken += (taken.empty() ? "" : " and ") + format("%g %s of line %zu", *value, unit, giver->number);
    if (text_key(giver->session) != text_key(line.entry.session))
      taken += giver->session.empty() ? ", without a session" : ", session " + giver->session;
  };
  take(line.mass_kg, &Giver::mass_kg, "weight", "kg");
  take(line.height_m, &Giver::height_m, "height", "m");
  if (taken.empty()) return {};
  return {{Severity::info, "body_of_other_line",
           format("line %zu of the sheet has no %s; decid takes %s, of the same person", line.number, lacking.c_str(),
                  taken.c_str())}};
}

}  // namespace decid
