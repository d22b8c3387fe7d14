// What the coordinates of each chain mean, chain by chain, as the kernels need it. Not installed.
#pragma once

#include <array>

#include "identify/posterior/density.hpp"

namespace decid::posterior {

struct Density::Chains {
  using Lanes = std::array<double, lanes>;
  std::array<Lanes, globals> value, by_coordinate;  // of each quantity, and its derivative by its coordinate
  Lanes noise_rad;                                  // the sensor's noise in the mean of a block
  Lanes radius, noise_gain, by_nv;                  // r, Nv / r, and its derivative by Nv
  std::array<Lanes, 2> delay_first, delay_turn, start_first, start_turn;  // complex
};

}  // namespace decid::posterior
