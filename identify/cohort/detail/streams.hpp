// The stream of random numbers (base/math/random.hpp) that studies use. Its number determines the bits of their draws.
#pragma once

#include "base/math/random.hpp"

namespace decid::cohort::streams {

inline constexpr Stream cohort{17};  ///< item: chain and sweep of the hierarchical model; a person of a planned study

}  // namespace decid::cohort::streams
