// The streams of random numbers (base/math/random.hpp) that posteriors use. Their numbers determine the bits of draws.
#pragma once

#include "base/math/random.hpp"

namespace decid::posterior::streams {

inline constexpr Stream chains{10};     ///< item: group of chains; its starts, momenta and choices
inline constexpr Stream particles{11};  ///< item: particle; its start, jumps and choices
inline constexpr Stream design{18};     ///< item: attempt at a planned person; bit 62: its noise, 63: its estimate

}  // namespace decid::posterior::streams
