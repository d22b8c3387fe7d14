// The streams of random numbers (base/math/random.hpp) that simulated trials use. Their numbers determine the bits of
// trials and data sets.
#pragma once

#include "base/math/random.hpp"

namespace decid::sim::streams {

inline constexpr Stream base_parameters{1};   ///< item: attempt of the base set
inline constexpr Stream child_parameters{2};  ///< item: attempt of the enrichment
inline constexpr Stream vestibular_noise{3};  ///< item: attempt of the base set
inline constexpr Stream child_noise{4};       ///< item: attempt of the enrichment
/// Item: attempt (children: with bit 63 set) or number of the trial; index 0: the level of the noise.
inline constexpr Stream sensor_noise{5};
inline constexpr Stream recording{13};  ///< item: trial; its recording artefacts (sim/protocol/conditions.cpp)
inline constexpr Stream body{14};       ///< item: attempt; index 0: height

}  // namespace decid::sim::streams
