// Resampling of a signal by any ratio.
#pragma once

#include <cstddef>
#include <vector>

namespace decid::recording {

/// The continuation of a signal beyond its ends, for the resampling filter.
enum class Ends {
  held,       ///< the last value: for noise, where any other continuation would repeat the noise of the end
  reflected,  ///< the signal rotated about its last sample, 2 x(0) - x(-t): for movements. A slope continues; holding
              ///< the value would halve the velocity at the end. A rest stays a rest; the last sample keeps its value
};

/// Resamples by a windowed sinc: a low-pass of linear phase and no delay, with a Kaiser window of 52 samples of the
/// lower rate. Pass band to 0.40 of the lower rate within 0.1%, -6 dB at 0.45, stop band from 0.50 at -70 dB and below.
/// Any ratio. Equal rates: a copy. Returns floor(duration * to) samples; the first is at the time of the signal's
/// first. Throws Error for rates that are not positive and finite, and for a result of more than 100 million samples.
std::vector<double> resample(const std::vector<double>& signal, double from_hz, double to_hz, Ends ends = Ends::held);
/// Resamples one cycle of a periodic signal with the same filter. The `count` samples divide the cycle evenly; the
/// first is at the signal's first.
std::vector<double> resample_cycle(const std::vector<double>& signal, std::size_t count);
/// Resamples with the same filter and held ends. Returns `count` samples; the first is `start_s` after the signal's
/// first, at any time. Filters at equal rates, too. Throws Error for rates that are not positive and finite.
std::vector<double> resample(const std::vector<double>& signal, double from_hz, double to_hz, double start_s,
                             std::size_t count);

}  // namespace decid::recording
