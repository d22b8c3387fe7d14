// Changes within a sway, or between it and the protocol's tilt, as warnings. Not installed.
#pragma once

#include <optional>
#include <span>

#include "base/sample_range.hpp"
#include "base/warning.hpp"
#include "recording/quality/detail/response_check.hpp"

namespace decid::recording {

/// Findings of look_for_changes().
struct Changes {
  Warnings warnings;
  std::optional<double> other_start_s = {};  ///< of the warning `other_start`, positive after the protocol
};

/// Returns the cautions `stretch_off` (an unexplained movement of 0.3 degrees and 14 medians within a block),
/// `unusual_movement` (one of 0.5 to 4 s, or to another level, of 0.3 degrees and 8 standard deviations; not with
/// `stretch_off`), and one of `no_response` (in one part, as from a platform that stopped; not with a movement at the
/// start, which hides the response or imitates one), `other_start`, `time_slips` and `clock_differs`. Skips the first
/// two if `known`, the sway's other warnings, contain jumps, spikes or a frozen sensor. gaps: samples that were not
/// measured. prediction: of the sway by the tilt; from_hz: the recording's rate.
Changes look_for_changes(const ResponseCheck& check, std::span<const double> sway_rad,
                         std::span<const SampleRange> gaps, const Prediction& prediction, double from_hz,
                         const Warnings& known);

}  // namespace decid::recording
