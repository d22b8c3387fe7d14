// Sample rates that a file states in words outside of its samples: "Sampling rate (Hz),100", "Interval= 0.01 s".
// Not installed.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace decid::recording {

struct StatedRate {
  double hz = 0.0;
  std::string phrase;     ///< as in the file: "Sampling rate (Hz)"
  bool is_plain = false;  ///< names its subject; "Rate" and "Frequency" do not
};

/// Adds the rates that one line states. The whole phrase must be in a list: "Sampling rate", "DataRate",
/// "Abtastfrequenz", "fs", "Frequency", unlike "Heart rate", "Cutoff frequency", "ANALOG_FREQUENCY" and "Offset". One
/// number of 1 to 100,000 Hz must follow it, or precede it ("30 FPS"), with or without a unit. Sampling intervals count
/// if they have a unit: "Sampling interval (ms),10", "10 msec/sample".
void add_stated_rates(std::string_view line, std::vector<StatedRate>& rates);

/// Splits a line, without the signs of a comment, into names and figures, at tabs, semicolons, colons, equals signs and
/// quotes, and at commas outside of numbers.
std::vector<std::string_view> fields_of(std::string_view line);

/// Returns the rates whose phrases name their subject, or all rates if none does; equal rates count once.
std::vector<StatedRate> candidates(const std::vector<StatedRate>& rates);

/// Returns "'Sampling rate' 100 Hz, 'Frame rate' 50 Hz".
std::string to_list(const std::vector<StatedRate>& rates);

}  // namespace decid::recording
