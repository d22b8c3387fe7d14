// The stream of random numbers (base/math/random.hpp) that predictive checks use. Its number determines their bits.
#pragma once

#include "base/math/random.hpp"

namespace decid::streams {

inline constexpr Stream predictive{12};  ///< item: trial simulated from a draw; its measurement noise: with bit 63 set

}  // namespace decid::streams
