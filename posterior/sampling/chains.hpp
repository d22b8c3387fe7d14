// The quantities of each chain's coordinates, chain by chain, as the kernels need them. Not installed.
#pragma once

#include <array>

#include "posterior/density/density.hpp"

namespace decid::posterior {

struct Density::Chains {
  using Lanes = std::array<double, lanes>;
  std::array<Lanes, globals> value,
      d_coordinate;  // of each quantity, and its derivative by its coordinate; for noises only the value
  NoiseLevels levels;
  // Derivatives of the logarithms of white, slow and memory by their coordinates; slow also has a derivative by the
  // white noise's coordinate.
  Lanes d_white, d_slow, d_memory, d_slow_white;
  Lanes radius, noise_gain, d_nv;                                         // r, Nv / r, and its derivative by Nv
  std::array<Lanes, 2> delay_first, delay_turn, start_first, start_turn;  // complex
};

}  // namespace decid::posterior
