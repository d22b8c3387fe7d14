// Sample rates that a file states beside its samples, in words: "Sampling rate (Hz),100", "Interval= 0.01 s".
// Not installed.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace decid::recording {

struct StatedRate {
  double hz = 0.0;
  std::string phrase;     ///< as it stands there: "Sampling rate (Hz)"
  bool is_plain = false;  ///< says whose rate it is; "Rate" or "Frequency" do not
};

/// Adds those of one line. A phrase counts if it is one of a list as a whole: "Sampling rate", "DataRate",
/// "Abtastfrequenz", "fs", "Frequency"; "Heart rate", "Cutoff frequency", "ANALOG_FREQUENCY" and "Offset" are none. One
/// number of 1 to 100,000 Hz must follow it, or stand before it ("30 FPS"), with or without a unit. Sampling intervals
/// count where their unit is there: "Sampling interval (ms),10", "10 msec/sample".
void add_stated_rates(std::string_view line, std::vector<StatedRate>& rates);

/// Returns the rates that say whose they are, or all if none does; several of one rate count once.
std::vector<StatedRate> candidates(const std::vector<StatedRate>& rates);

/// "'Sampling rate' 100 Hz, 'Frame rate' 50 Hz"
std::string list_of(const std::vector<StatedRate>& rates);

}  // namespace decid::recording
