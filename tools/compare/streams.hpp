// The streams of random numbers (base/math/random.hpp) that iterative fits use. Their numbers determine the bits of
// fits.
#pragma once

#include "base/math/random.hpp"

namespace decid::iterative {

inline constexpr Stream search_stream{8};  ///< item: search
inline constexpr Stream noise_stream{9};   ///< item: realisation of the vestibular noise

}  // namespace decid::iterative
