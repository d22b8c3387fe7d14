// Resampling of a signal by any ratio.
#pragma once

#include <cstddef>
#include <vector>

namespace decid::recording {

/// What the resampling's filter sees beyond a signal's ends.
enum class Ends {
  held,       ///< the last value: for noise, where any other continuation would show the end's noise again
  reflected,  ///< the signal turned about its last sample, 2 x(0) - x(-t): for movements. A slope goes on instead of
              ///< stopping, which halves the velocity at the end; a rest stays one; the last sample keeps its value
};

/// Windowed-sinc resampling: a low-pass of linear phase and no delay, Kaiser window, 52 samples of the lower rate long.
/// Pass band to 0.40 of the lower rate within 0.1%, -6 dB at 0.45, stop band from 0.50 at -70 dB and below. Any ratio.
/// Equal rates: a copy. The result has floor(duration * to) samples, the first at the time of the signal's first.
/// Throws Error for rates that are not positive and finite, and for a result of more than 100 million samples.
std::vector<double> resample(const std::vector<double>& signal, double from_hz, double to_hz, Ends ends = Ends::held);
/// The same filter on one cycle of a periodic signal: its first sample follows its last. `count` samples, the first at
/// the signal's first, divide the cycle evenly.
std::vector<double> resample_cycle(const std::vector<double>& signal, std::size_t count);
/// The same filter, ends held: `count` samples, the first at `start_s` after the signal's first, which need not be a
/// sample's time. Filters also at equal rates. Throws Error for rates that are not positive and finite.
std::vector<double> resample(const std::vector<double>& signal, double from_hz, double to_hz, double start_s,
                             std::size_t count);

}  // namespace decid::recording
