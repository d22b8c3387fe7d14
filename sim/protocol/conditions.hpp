// Recording artefacts: changes of a sway by laboratories, drawn for each trial. A condition is a line of the table in
// conditions.cpp, and a step of record().
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

namespace decid::sim {

struct Protocol;

/// The artefacts in the order in which they act.
enum class Condition : std::size_t {
  start,       ///< s: the recording begins this much later than the protocol, or earlier
  gain,        ///< relative error of the sway's scale, positive or negative: a wrong lever arm
  offset,      ///< degrees: a constant is added or subtracted
  drift,       ///< degrees: a straight line is added or subtracted, from 0 to this at the end
  slow_noise,  ///< degrees: sd of noise with a memory of 1 to 30 s
  frozen,      ///< s: in every 10 s, at a random place, the last value lasts this long
  lost,        ///< s: in every 10 s a stretch of this length is lost, and bridged by a straight line
  average,     ///< s: moving average over this time: causal in half of the trials, else centred
  low_pass,    ///< Hz: Butterworth filter of order 1, 2 or 4; causal, or forward and backward, half of the trials each
  quantisation,  ///< degrees: rounded to multiples of this
};
inline constexpr std::size_t condition_count = 10;

/// The fraction of trials with a condition, and the condition's size.
struct Severity {
  double fraction = 0.0;         ///< of the trials, 0 to 1; the others do not have the condition
  double low = 0.0, high = 0.0;  ///< drawn log-uniform between them, uniform if low is 0
};

struct Conditions {
  std::array<Severity, condition_count> severity{};

  Severity& operator[](Condition condition) { return severity[static_cast<std::size_t>(condition)]; }
  const Severity& operator[](Condition condition) const { return severity[static_cast<std::size_t>(condition)]; }
};

struct ConditionInfo {
  const char* key;  ///< as in protocol files
  double max;       ///< the largest value
  bool has_sign;    ///< equally often negative
};
const ConditionInfo& info(Condition condition);

/// Motion of the body before a recording begins.
enum class Before { at_rest, moving };

/// Shifts a recording of at least 3 samples to begin `samples` later, with cubics between samples. at_rest: holds the
/// first sample before the recording, and continues the line through the last two after it. moving: continues the
/// parabola through the outermost three samples at both ends.
void begin_later(std::span<double> values, double samples, Before before = Before::at_rest);

/// Returns the size of a condition in trial `item`; 0: none.
double drawn(const Conditions& conditions, Condition condition, std::uint64_t seed, std::uint64_t item);

/// Applies all of the protocol's recording artefacts to the sway of trial `item`, and its white measurement noise
/// between lost samples and slow noise. sway_rad: at the protocol's rate, from its start.
void record(const Protocol& protocol, std::uint64_t seed, std::uint64_t item, std::span<double> sway_rad);

}  // namespace decid::sim
