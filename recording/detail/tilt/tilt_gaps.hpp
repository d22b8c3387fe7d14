// Gaps of a measured tilt. Not installed.
#pragma once

#include <vector>

#include "recording/detail/tilt/tilt_match.hpp"
#include "recording/recording.hpp"

namespace decid::recording {

/// Returns the start at which the protocol's tilt explains the most of the measured samples: the squared correlation
/// times their number. A part of a stimulus alone may follow another part, reversed. The protocol's own sign wins over
/// the other one that explains hardly more, as in tilt_match.hpp. decid searches at about 10 Hz, and
/// then beside the best start at the full rate; a parabola gives the start between samples, as in tilt_match.hpp.
/// Filled samples have no influence. `measured`: the recording's tilt at rate_hz; `expected`: the protocol's. from_hz:
/// the recording's rate.
double start_beside_gaps(const Recording& recording, const std::vector<double>& measured,
                         const std::vector<double>& expected, double from_hz, double rate_hz);

/// Fits the protocol's tilt to the recording's, by least squares over its measured samples, and fills the recording's
/// tilt_gaps with the fit. Returns the gain and the correlation of the measured samples. `expected`: the protocol's
/// tilt at rate_hz. start_s: its start in the recording of from_hz.
Match fill_as_prescribed(Recording& recording, const std::vector<double>& expected, double start_s, double from_hz,
                         double rate_hz);

}  // namespace decid::recording
