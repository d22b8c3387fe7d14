// The body in segments, from a participant's mass and height: leg (shanks and thighs) and trunk (with head and arms);
// the feet stay on the platform. Source: Winter, Biomechanics and Motor Control of Human Movement, 4th edition,
// tables 4.1 (segment masses, centres of mass, radii of gyration) and figure 4.1 (segment lengths as fractions of the
// height).
#pragma once

#include <string>

#include "sim/protocol/protocol.hpp"

namespace decid::sim {

struct Participant {
  double mass_kg = 88.86;  ///< of the whole body, feet included
  double height_m = 1.80;
};

/// Both legs as one rigid segment, and everything above the hip as another. Heights count along the segment from its
/// lower joint; inertias are about the segment's own centre of mass.
struct Segments {
  double leg_mass_kg, leg_length_m, leg_com_m, leg_inertia_kgm2;
  double trunk_mass_kg, trunk_com_m, trunk_inertia_kgm2;
  double trunk_length_m;  ///< hip to shoulder

  double mass_kg() const { return leg_mass_kg + trunk_mass_kg; }
  /// Returns the height of the common centre of mass above the ankle, standing straight.
  double com_height_m() const;
  /// Returns the common inertia about the ankle, standing straight.
  double inertia_kgm2() const;
  /// Returns the gravitational stiffness of the trunk about the hip, N m/rad.
  double trunk_mgh() const { return trunk_mass_kg * gravity * trunk_com_m; }
};

/// Returns the segments of a participant. Throws Error unless mass and height are positive and below 500 kg and 3 m.
Segments make_segments(const Participant& participant);

/// Returns the body of a person. Throws Error beyond 250 kg or if the body mass index is not from 12 to 60 kg/m^2,
/// which usually indicates a lost decimal point or swapped values.
Body body_of_participant(const Participant& participant);

/// Returns the straight body as a single inverted pendulum.
Body make_body(const Segments& segments);

/// Returns the participant with this straight body: mass and height follow from its mass and centre of mass. Throws
/// Error if such a participant's inertia differs by more than 0.1%: the body then does not consist of Winter's
/// segments.
Participant make_participant(const Body& body);

/// Returns m g h, or a stiffness, in N m/rad for users: "839", below 100 with three significant digits ("0.213").
std::string mgh_text(double mgh_nm_rad);

/// Returns true if the body has a participant (make_participant), unlike a robot's.
bool is_person(const Body& body);
/// Throws Error, of `where`, if a person's body is to replace the body of the protocol, which is not a person's.
void refuse_person(const Body& body, const Protocol& protocol, const std::string& where);

}  // namespace decid::sim
