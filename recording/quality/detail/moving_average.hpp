// Finds recordings that were smoothed by a moving average. Not installed.
#pragma once

#include <span>

namespace decid::recording {

/// Returns the length in s of the moving average that smoothed a sway, or of the time for which each value was held; 0
/// if there is none. Finds lengths from 0.04 s to 2 s, and to a ninetieth of the sway. The spectrum of such an average
/// is 0 at the multiples of 1 / length, so the mean logarithm of the power is lower there than between them. `held_s`:
/// the duration of each state of the platform's tilt, whose spectrum has such zeros itself; 0: the tilt has no states.
/// Zeros of the tilt do not count, so an average over that length, a half or a third of it is not found.
double moving_average_s(std::span<const double> sway_rad, double rate_hz, double held_s = 0.0);

}  // namespace decid::recording
