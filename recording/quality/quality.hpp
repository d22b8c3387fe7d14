// What sensors, plugs and programs leave in a recording of sway: looked for in its samples. Not installed.
#pragma once

#include <span>

#include "base/warning.hpp"

namespace decid::recording {

/// Adds a warning of each of these that there is; none for signals under two seconds, in which none is plain. The
/// signal begins `begin_s` after the recording, from whose start the warnings count:
/// - frozen: runs of one value for 0.1 s and at least 5 samples, and twelve times as long as the runs in which half of
///   the samples are (those of a coarse sensor are long), but zeros at the start, where simulated bodies are at rest; a
///   caution if they make up 2 % of the signal;
/// - coarse_steps: values are multiples of a step of 0.02 degrees or more; a caution from 0.2 on;
/// - spikes: single samples off the line between their neighbours, or the first one off the line through the next two,
///   by more than 0.05 degrees, 20 times the median of that and three steps of a coarse sensor; a caution;
/// - smooth: no sensor noise between 12 and 25 Hz, where sway has nothing and sensors have: below 0.0003 degrees by the
///   median of fourth differences of samples averaged to about 50 Hz. It was smoothed or simulated. From 50 Hz on. Also
///   a moving average (moving_average.hpp) at any rate; a caution beyond 0.25 s, which no model was trained on.
///   held_s: how long each state of the platform's tilt lasts, or 0.
void look_for_faults(std::span<const double> sway_rad, double rate_hz, Warnings& warnings, double begin_s = 0.0,
                     double held_s = 0.0);

}  // namespace decid::recording
