// The constants of the double pendulum's equations, written again for the tests.
#pragma once

#include "sim/segments.hpp"

namespace decid::test {

struct Constants {
  explicit Constants(const sim::Segments& s)
      : a1(s.leg_mass_kg * s.leg_com_m * s.leg_com_m + s.trunk_mass_kg * s.leg_length_m * s.leg_length_m +
           s.leg_inertia_kgm2),
        a2(s.trunk_mass_kg * s.trunk_com_m * s.trunk_com_m + s.trunk_inertia_kgm2),
        b(s.trunk_mass_kg * s.leg_length_m * s.trunk_com_m),
        g1(9.81 * (s.leg_mass_kg * s.leg_com_m + s.trunk_mass_kg * s.leg_length_m)),
        g2(9.81 * s.trunk_mass_kg * s.trunk_com_m),
        w1(g1 / (9.81 * s.mass_kg() * s.com_height_m())),
        w2(g2 / (9.81 * s.mass_kg() * s.com_height_m())) {}
  double a1, a2, b, g1, g2, w1, w2;
};

}  // namespace decid::test
