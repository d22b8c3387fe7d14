// The quantities of each chain's coordinates, chain by chain, as the kernels need them. Not installed.
#pragma once

#include <array>

#include "posterior/density/density.hpp"

namespace decid::posterior {

struct Density::Chains {
  using Lanes = std::array<double, lanes>;
  // The value of each global, by its place, and its derivative by its coordinate; noises have only the value.
  std::array<Lanes, max_globals> value, d_coordinate;
  std::array<Lanes, sim::Coefficients::count> coefficients;  // of the family
  const Lanes& operator[](sim::Coefficient c) const { return coefficients[static_cast<std::size_t>(c)]; }
  NoiseLevels levels;
  // Derivatives of the logarithms of white, slow and memory by their coordinates; slow also has a derivative by the
  // white noise's coordinate.
  Lanes d_white, d_slow, d_memory, d_slow_white;
  Lanes radius, noise_gain, d_nv;                                         // r, Nv / r, and its derivative by Nv
  std::array<Lanes, 2> delay_first, delay_turn, start_first, start_turn;  // complex
};

}  // namespace decid::posterior
