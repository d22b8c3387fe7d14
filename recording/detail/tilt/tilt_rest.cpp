// The platform's rests at both ends: see tilt_rest.hpp.
#include "recording/detail/tilt/tilt_rest.hpp"

#include <algorithm>
#include <cmath>

namespace decid::recording {

SampleRange moving_samples(std::span<const double> tilt) {
  constexpr double rest_range = 0.1;  // sensors of tilt are less noisy
  if (tilt.empty()) return {};
  const auto [lowest, highest] = std::ranges::minmax(tilt);
  const double limit = rest_range * (highest - lowest);
  const auto moves_from = [&](double level) { return [=](double value) { return std::abs(value - level) > limit; }; };
  const auto first = std::find_if(tilt.begin(), tilt.end(), moves_from(tilt.front()));
  const auto last = std::find_if(tilt.rbegin(), tilt.rend(), moves_from(tilt.back()));
  if (first == tilt.end() || last == tilt.rend() || first >= last.base()) return {};
  return {static_cast<std::size_t>(first - tilt.begin()), static_cast<std::size_t>(last.base() - tilt.begin())};
}

}  // namespace decid::recording
