// How trials are recorded: what laboratories do to a sway, drawn anew for each trial. A condition is a line of the
// table in conditions.cpp, and a step of record().
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

namespace decid::sim {

struct Protocol;

/// In the order in which they act.
enum class Condition : std::size_t {
  start,       ///< s: the recording begins so much later than the protocol, or earlier
  gain,        ///< the sway is so much too large, as a part of itself, or too small: a wrong lever arm
  offset,      ///< degrees: a constant is added, or subtracted
  drift,       ///< degrees: so is a straight line, from 0 to that at the end
  slow_noise,  ///< degrees: deviation of noise that forgets within 1 to 30 s
  frozen,      ///< s: in every 10 s, at a random place, the last value stands for so long
  lost,        ///< s: in every 10 s so long a stretch is lost, and bridged by a straight line
  average,     ///< s: moving average over so long, of what was, in half of the trials; else about the sample
  low_pass,    ///< Hz: Butterworth filter of order 1, 2 or 4; causal, or forward and backward, half of the trials each
  quantisation,  ///< degrees: rounded to multiples of that
};
inline constexpr std::size_t condition_count = 10;

/// Which trials a condition is of, and how much of it they have.
struct Severity {
  double share = 0.0;            ///< of the trials, 0 to 1; the others have none
  double low = 0.0, high = 0.0;  ///< drawn log-uniform between them, uniform if low is 0
};

struct Conditions {
  std::array<Severity, condition_count> severity{};

  Severity& operator[](Condition condition) { return severity[static_cast<std::size_t>(condition)]; }
  const Severity& operator[](Condition condition) const { return severity[static_cast<std::size_t>(condition)]; }
};

struct ConditionInfo {
  const char* key;  ///< as in protocol files
  double most;      ///< the largest value
  bool has_sign;    ///< it is as often negative
};
const ConditionInfo& info(Condition condition);

/// Motion of the body before a recording begins.
enum class Before { at_rest, moving };

/// Shifts a recording, of 3 samples at least, to begin `samples` later, with cubics between samples. at_rest: the first
/// sample holds before the recording, and a line through the last two goes on behind it. moving: at both ends the
/// parabola through the outermost three samples goes on.
void begin_later(std::span<double> values, double samples, Before before = Before::at_rest);

/// How much of a condition trial `item` has; 0: none.
double drawn(const Conditions& conditions, Condition condition, std::uint64_t seed, std::uint64_t item);

/// Makes of the sway of trial `item` what a laboratory records of it: all of its protocol's conditions, and between
/// lost samples and slow noise the sensor's white noise. sway_rad: at the protocol's rate, from its start.
void record(const Protocol& protocol, std::uint64_t seed, std::uint64_t item, std::span<double> sway_rad);

}  // namespace decid::sim
