// Recordings from text in a file that goes away.
#pragma once

#include <algorithm>
#include <string>

#include "recording/recording.hpp"
#include "sim/protocol/protocol.hpp"
#include "tests/helpers.hpp"

namespace decid::test {

inline recording::Recording read(const std::string& text, const recording::RecordingOptions& options = {}) {
  const TemporaryFolder folder;
  return recording::read_recording(write_text(folder / "r.csv", text), options);
}

/// Returns the first warning with this code; null without one.
inline const Warning* warning(const Warnings& warnings, const std::string& code) {
  const auto found = std::ranges::find(warnings, code, &Warning::code);
  return found == warnings.end() ? nullptr : &*found;
}

inline auto reading(const std::string& text, const recording::RecordingOptions& options = {}) {
  return [text, options] { read(text, options); };
}

/// The recording is 1, 2, 3 degrees at 100 Hz.
inline void check_one_two_three(const std::string& text, const recording::RecordingOptions& options = {}) {
  INFO(text);
  const recording::Recording recording = read(text, options);
  CHECK(recording.rate_hz == 100.0);
  const auto& rad = recording.signals.at(recording::com_sway).rad;
  REQUIRE(rad.size() == 3);
  for (std::size_t k = 0; k < 3; ++k) CHECK(rad[k] == static_cast<double>(k + 1) * sim::rad_per_deg);
}

}  // namespace decid::test
