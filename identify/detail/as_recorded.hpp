// A simulated sway as a recording has it that starts later or earlier than the protocol. Not installed.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace decid {

/// Returns the value at a place between samples, which is linear; beyond either end the end is held. At a rate of 100
/// Hz this loses at most 0.2% at 2 Hz. The values are not empty.
inline double value_at(std::span<const double> values, double place) {
  const double inside = std::clamp(place, 0.0, static_cast<double>(values.size() - 1));
  const auto below = static_cast<std::size_t>(inside);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (inside - static_cast<double>(below)) * (values[above] - values[below]);
}

/// Returns as many values, from this number of samples later on.
inline std::vector<double> started_later(std::span<const double> values, double samples) {
  std::vector<double> moved(values.size());
  for (std::size_t k = 0; k < moved.size(); ++k) moved[k] = value_at(values, static_cast<double>(k) + samples);
  return moved;
}

}  // namespace decid
