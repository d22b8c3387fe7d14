// Low-passes that smoothed a recording: Butterworth's, found by the spectrum of its measurement noise, and moving
// averages; and how to undo them.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "base/sample_range.hpp"

namespace decid::recording {

/// A Butterworth low-pass, digital by the bilinear transform, or a moving average.
struct LowPass {
  int order = 0;                           ///< of one pass, 1 to 4; 0: a moving average
  bool both_ways = false;                  ///< it ran forwards and backwards, so it delays nothing
  double cutoff_hz = 0.0;                  ///< of one pass, -3 dB
  double rate_hz = 0.0;                    ///< of the samples that it filtered
  double gain_low = 1.0, gain_high = 1.0;  ///< at low_pass_hz: the range over all filters that are as likely
  int averaged = 0;                        ///< samples of a moving average

  /// Returns the gain at a frequency in Hz, below half of rate_hz.
  double gain_at(double hz) const;
  /// Returns the delay at low frequencies in s, if it runs forwards only; 0 if both ways. The spectrum does not show
  /// whether a moving average is centred: of one, returns the delay of an average over the samples before.
  double delay_s() const;
};

/// Returns the moving average over a number of samples, 1 or more.
LowPass moving_average(int samples, double rate_hz);

/// The frequency in Hz at which LowPass states its gain: above it a fit ignores the sway.
inline constexpr double low_pass_hz = 2.5;

/// Returns the Butterworth low-pass that smoothed a sway; empty if there is none, or if it changes nothing up to
/// low_pass_hz and delays nothing. White measurement noise shows it from 2 Hz to 60 Hz, or to 0.48 of a rate below 125
/// Hz: its power falls as the filter's gain, down to the rounding of the file. Cutoffs up to 60 Hz, or 0.3 of a rate
/// below 200 Hz, are compared. Sway and slow noise in front of the filter fall with powers of the frequency. The filter
/// is found if it explains the spectrum, and no such powers do. Below about 2 Hz only its slope shows: gain_low and
/// gain_high then differ by far, down to a cutoff of 0.3 Hz. An exponential moving average falls as a power of the
/// frequency, so its low cutoffs are not found at all. Empty for rates below 25 Hz and for signals that are empty or
/// too short to tell.
std::optional<LowPass> find_low_pass(std::span<const double> sway_rad, double rate_hz);

/// Returns true if a fit can undo a low-pass: its gain at low_pass_hz is known within 0.08 and at least 0.1.
bool can_undo(const LowPass& filter);
/// Returns true if an estimate suffers from a low-pass: a fit cannot undo it, or its gain at low_pass_hz is below 0.7.
bool removes_much(const LowPass& filter);
/// Returns the sway before the low-pass: divided by its gain in the frequency domain. Gains below 0.05 count as 0.05,
/// because there is nothing but rounding: such frequencies stay too small. Phases stay, so a filter that ran forwards
/// only still delays the sway. Noise and the error of the gain at a frequency are divided by the gain too. rate_hz: of
/// the sway, which may be resampled since the filter. Empty for an empty sway.
std::vector<float> undo(const LowPass& filter, std::span<const float> sway_rad, double rate_hz);
/// Returns the gaps and a period of the cutoff on either side of each, within the samples: undo() amplifies the kinks
/// at the ends of a bridged gap, which ring into the measured samples.
std::vector<SampleRange> gaps_after_undo(const LowPass& filter, std::span<const SampleRange> gaps, double rate_hz,
                                         std::size_t samples);

}  // namespace decid::recording
