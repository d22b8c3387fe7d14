// Bodies of people: see person_bodies.hpp.
#include "identify/study/detail/person_bodies.hpp"

#include <tuple>

#include "base/text.hpp"
#include "identify/study/detail/text_key.hpp"

namespace decid {

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

bool PersonBodies::fill(SheetLine& line, Warnings& warnings) const {
  if (line.mass_kg && line.height_m) return false;
  const auto found = givers_.find(text_key(line.entry.participant));
  if (found == givers_.end()) return false;
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
  if (taken.empty()) return false;
  add_info(warnings, "body_of_other_line",
           format("line %zu of the sheet has no %s; decid takes %s, of the same person", line.number, lacking.c_str(),
                  taken.c_str()));
  return true;
}

}  // namespace decid
