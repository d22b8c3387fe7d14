// Time that is missing or doubled in a recording, and wrong clocks, by the measured tilt. Not installed.
#pragma once

#include <span>
#include <vector>

#include "base/sample_range.hpp"
#include "base/warning.hpp"
#include "recording/trial.hpp"

namespace decid::recording {

/// Returns the caution `time_slips` if a measured tilt follows the protocol with different delays in consecutive parts,
/// as after a missing stretch, or `clock_differs` if its delay grows evenly, as by a wrong clock; else nothing. `tilt`:
/// at the protocol's samples, `gaps` of them. from_hz: the recording's rate. start_was_given: the tilt did not
/// determine the start, so a constant delay is a slip too.
Warnings look_for_tilt_slips(const std::vector<double>& tilt, std::span<const SampleRange> gaps,
                             const ProtocolPlan& plan, double from_hz, bool start_was_given);

}  // namespace decid::recording
