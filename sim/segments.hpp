// The body in segments, from a subject's mass and height: leg (shanks and thighs) and trunk (with head and arms); the
// feet stay on the platform.
// Source: Winter, Biomechanics and Motor Control of Human Movement, 4th edition, tables 4.1 (segment masses, centres of
// mass, radii of gyration) and figure 4.1 (segment lengths as parts of the height).
#pragma once

#include "sim/protocol/protocol.hpp"

namespace decid::sim {

struct Subject {
  double mass_kg = 88.86;  ///< the whole body, feet included
  double height_m = 1.80;
};

/// Both legs as one, and all above the hip as another rigid segment. Heights are along the segment from its lower
/// joint; inertias are about the segment's own centre of mass.
struct Segments {
  double leg_mass_kg, leg_length_m, leg_com_m, leg_inertia_kgm2;
  double trunk_mass_kg, trunk_com_m, trunk_inertia_kgm2;
  double trunk_length_m;  ///< hip to shoulder

  double mass_kg() const { return leg_mass_kg + trunk_mass_kg; }
  /// Height of the common centre of mass above the ankle, standing straight.
  double com_height_m() const;
  /// Common inertia about the ankle, standing straight.
  double inertia_kgm2() const;
  /// Gravitational stiffness of the trunk about the hip, N m/rad.
  double trunk_mgh() const { return trunk_mass_kg * gravity * trunk_com_m; }
};

/// Throws Error unless mass and height are positive and below 500 kg and 3 m.
Segments segments_of(const Subject& subject);

/// Returns the body of a person. Throws Error beyond 250 kg or if the body mass index is not from 12 to 60 kg/m^2,
/// which mostly means a lost comma or swapped values.
Body body_of_person(const Subject& person);

/// The single inverted pendulum that the straight body is.
Body body_of(const Segments& segments);

/// The subject whose straight body this is: mass and height follow from its mass and centre of mass. Throws Error if
/// such a subject's inertia differs by more than 0.1%: the body is then not made of Winter's segments.
Subject subject_of(const Body& body);

}  // namespace decid::sim
