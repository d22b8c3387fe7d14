// Bodies that few people have: see body_warnings.hpp.
#include "identify/body_warnings.hpp"

#include "base/error.hpp"
#include "base/text.hpp"
#include "sim/segments.hpp"

namespace decid {

Warnings body_warnings(const sim::Body& body) {
  constexpr double low_kg_m2 = 13.0, high_kg_m2 = 45.0;
  Warnings warnings;
  try {
    const sim::Participant person = sim::make_participant(body);
    const double index = person.mass_kg / (person.height_m * person.height_m);
    if (index < low_kg_m2 || index > high_kg_m2)
      add_caution(warnings, "implausible_body",
                  format("a body of %.1f kg and %.2f m has a body mass index of %.0f kg/m2, which is rare: check that "
                         "the weight is in kg (154 lb are 70 kg) and the height is the person's",
                         person.mass_kg, person.height_m, index));
  } catch (const Error&) {  // not a person's body
    warnings.clear();
  }
  return warnings;
}

}  // namespace decid
