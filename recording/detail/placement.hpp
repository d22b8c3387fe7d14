// The part of a recording that is a trial of a protocol: cut to its samples, its gaps, its length in errors and
// warnings. Not installed.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/sample_range.hpp"
#include "recording/recording.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::recording {

/// The number of samples by which rounding alone may change lengths.
inline constexpr double length_rounding = 1e-6;

/// The trial's samples that a recording covers, k = first .. last, and the trial's start in the recording.
struct TrialPlacement {
  double start_s = 0.0;
  long long first = 0, last = -1;
};

/// Returns the trial's samples; those beyond the ends of the recording are the mirror image of their neighbours.
std::vector<double> cut(const std::vector<double>& signal, double from_hz, double to_hz, const TrialPlacement& place,
                        std::size_t samples);

/// Returns the gaps among the trial's samples, without short ones. A resampled gap is a sample of the lower rate longer
/// at either end. The samples that the recording lacks are gaps too.
std::vector<SampleRange> gaps_in_trial(const std::vector<SampleRange>& gaps, double from_hz, double rate_hz,
                                       const TrialPlacement& place, std::size_t samples);

/// Returns the advice for writing a protocol like this one with other settings.
std::string to_write(const sim::Protocol& protocol);

/// Throws Error for a recording that has too few samples after the protocol's start. known_start_s: the start, in s
/// after the first sample, if it was given or a measured tilt tells it.
[[noreturn]] void refuse_length(const Recording& recording, const sim::Protocol& protocol,
                                std::optional<double> known_start_s);
/// Warns of ignored samples of a longer recording and of invented samples of a shorter one. Without a start, one
/// warning names the ignored samples and time 0 if the times begin before 0 and the protocol fits behind time 0.
void warn_of_length(Recording& recording, const sim::Protocol& protocol, const TrialPlacement& place,
                    bool start_was_given);

}  // namespace decid::recording
