// Winter's segments: see segments.hpp.
#include "sim/segments.hpp"

#include <cmath>

#include "base/error.hpp"
#include "base/text.hpp"
#include "sim/protocol/detail/checker.hpp"

namespace decid::sim {
namespace {

// Fractions of the body's mass: 2 shanks of .0465 and 2 thighs of .100; head, arms and trunk. The feet's .029 are
// excluded.
constexpr double leg_mass = 0.293, trunk_mass = 0.678;
// Fractions of the body's height: ankle to hip (.530 - .039), hip to shoulder. The trunk's radius of gyration refers to
// .34, which gives the body of 88.86 kg and 1.80 m its inertia of 101.895 kg m2.
constexpr double leg_length = 0.491, trunk_length = 0.288, gyration_length = 0.34;
// Fractions of these lengths: centres of mass above the lower joint, radii of gyration about the centre of mass.
constexpr double leg_com = 0.553, leg_gyration = 0.326, trunk_com = 0.626, trunk_gyration = 0.496;

constexpr double square(double x) {
  return x * x;
}

}  // namespace

double Segments::com_height_m() const {
  return (leg_mass_kg * leg_com_m + trunk_mass_kg * (leg_length_m + trunk_com_m)) / mass_kg();
}

double Segments::inertia_kgm2() const {
  return leg_mass_kg * square(leg_com_m) + leg_inertia_kgm2 + trunk_mass_kg * square(leg_length_m + trunk_com_m) +
         trunk_inertia_kgm2;
}

Segments make_segments(const Participant& participant) {
  const auto check = [](const char* setting, double value, double high, const std::string& advice = {}) {
    if (value > 0.0 && value <= high) return;
    throw Error(Code::setting_out_of_range, "participant " + std::string(setting), "is " + given_text(value),
                "give a value above 0 and at most " + setting_text(high) + advice);
  };
  check("mass_kg", participant.mass_kg, 500.0);
  const double height = participant.height_m;
  const bool is_like_cm = height >= 100.0 && height <= 250.0;
  check("height_m", height, 3.0,
        is_like_cm ? "; if it is in cm, give " + setting_text(std::round(100.0 * height) / 1e4) : std::string());
  Segments segments{};
  segments.leg_mass_kg = leg_mass * participant.mass_kg;
  segments.leg_length_m = leg_length * participant.height_m;
  segments.leg_com_m = leg_com * segments.leg_length_m;
  segments.leg_inertia_kgm2 = segments.leg_mass_kg * square(leg_gyration * segments.leg_length_m);
  segments.trunk_mass_kg = trunk_mass * participant.mass_kg;
  segments.trunk_length_m = trunk_length * participant.height_m;
  segments.trunk_com_m = trunk_com * trunk_length * participant.height_m;
  segments.trunk_inertia_kgm2 =
      segments.trunk_mass_kg * square(trunk_gyration * gyration_length * participant.height_m);
  return segments;
}

Body body_of_participant(const Participant& participant) {
  constexpr double max_kg = 250.0, min_index = 12.0, max_index = 60.0;
  const Body body = make_body(make_segments(participant));
  const double index = participant.mass_kg / square(participant.height_m);
  const std::string given = given_text(participant.mass_kg) + " kg and " + given_text(participant.height_m) + " m";
  if (participant.mass_kg > max_kg)
    throw Error(Code::setting_out_of_range, "mass and height", given + " exceed the maximum of 250 kg for a person",
                "give the weight in kg");
  if (!(index >= min_index && index <= max_index))
    throw Error(
        Code::setting_out_of_range, "mass and height",
        given + " give a body mass index of " + given_text(std::round(10.0 * index) / 10.0) + ", not from 12 to 60",
        "give the weight in kg and the height in m; describe a robot's body in a protocol");
  return body;
}

Body make_body(const Segments& segments) {
  return {
      .mass_kg = segments.mass_kg(), .com_height_m = segments.com_height_m(), .inertia_kgm2 = segments.inertia_kgm2()};
}

Participant make_participant(const Body& body) {
  // Both are proportional to the unknown values.
  const Participant unit{.mass_kg = 1.0, .height_m = 1.0};
  const Body model = make_body(make_segments(unit));
  const Participant participant{.mass_kg = body.mass_kg / model.mass_kg,
                                .height_m = body.com_height_m / model.com_height_m};
  const double inertia = make_body(make_segments(participant)).inertia_kgm2;
  if (std::abs(body.inertia_kgm2 - inertia) <= 1e-3 * inertia) return participant;
  throw Error(Code::setting_conflict, "body",
              "its inertia of " + setting_text(body.inertia_kgm2) + " kg m2 differs from that of Winter's segments, " +
                  setting_text(inertia) + ", so leg and trunk are unknown",
              "give the body as {\"participant\": {\"mass_kg\": .., \"height_m\": ..}}");
}

std::string mgh_text(double mgh_nm_rad) {
  return format(mgh_nm_rad < 99.95 ? "%.3g" : "%.0f", mgh_nm_rad);
}

bool is_person(const Body& body) {
  try {
    static_cast<void>(make_participant(body));
    return true;
  } catch (const Error&) {
    return false;
  }
}

void refuse_person(const Body& body, const Protocol& protocol, const std::string& where) {
  const Body& own = protocol.experiment.body;
  if (is_person(own) || !is_person(body)) return;
  throw Error(Code::setting_conflict, where,
              format("a person's body, m g h %s N m/rad, would replace the body of protocol '%s', which is not a "
                     "person's, m g h %s N m/rad",
                     mgh_text(body.mgh()).c_str(), protocol.name.c_str(), mgh_text(own.mgh()).c_str()),
              "leave mass and height out to fit the protocol's body, or delete its \"body\"");
}

}  // namespace decid::sim
