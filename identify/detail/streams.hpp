// Streams of random numbers (base/math/random.hpp) of predictive checks and of studies. Numbers determine their bits.
#pragma once

#include "base/math/random.hpp"

namespace decid::streams {

inline constexpr Stream predictive{12};  ///< item: trial simulated from a draw; its measurement noise: with bit 63 set
inline constexpr Stream cohort{17};  ///< item: chain and sweep of the hierarchical model; a person of a planned study

}  // namespace decid::streams
