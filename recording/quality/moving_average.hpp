// Finds recordings that were smoothed by a moving average. Not installed.
#pragma once

#include <span>

namespace decid::recording {

/// Returns the length in s of the moving average that a sway went through, or of the time for which each of its values
/// was held; 0 if there is none. Finds lengths from 0.04 s to 2 s, and to a ninetieth of the sway. The spectrum of such
/// an average is 0 at the multiples of 1 / length: the mean logarithm of the power there lies below that between them.
/// held_s: how long each state of the platform's tilt lasts, whose spectrum has such zeros itself: they do not count,
/// so an average over that length, or a half or third of it, is not found; 0: the tilt has no states.
double moving_average_s(std::span<const double> sway_rad, double rate_hz, double held_s = 0.0);

}  // namespace decid::recording
