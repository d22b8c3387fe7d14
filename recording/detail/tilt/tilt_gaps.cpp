// Gaps of a measured tilt: see tilt_gaps.hpp.
#include "recording/detail/tilt/tilt_gaps.hpp"

#include <algorithm>
#include <cmath>

#include "base/math/statistics.hpp"

namespace decid::recording {

double start_beside_gaps(const std::vector<double>& measured, const std::vector<SampleRange>& gaps,
                         const std::vector<double>& expected, double from_hz, double rate_hz) {
  constexpr double coarse_hz = 10.0, min_fraction = 0.4;
  const long step = std::max(1L, std::lround(rate_hz / coarse_hz)), count = std::ssize(expected);
  const long overhang = count / 4, samples = std::ssize(measured);
  std::vector<bool> is_measured(measured.size(), true);
  for (const SampleRange& gap : gaps) {
    const double first = std::floor(static_cast<double>(gap.first) / from_hz * rate_hz);
    const double end = std::ceil(static_cast<double>(gap.end) / from_hz * rate_hz);
    for (auto k = static_cast<std::size_t>(first); k < std::min(static_cast<std::size_t>(end), measured.size()); ++k)
      is_measured[k] = false;
  }
  double largest = 0.0, start_s = 0.0;
  std::vector<double> played, prescribed;
  for (long start = -overhang; start <= samples - count + overhang; start += step) {
    played.clear();
    prescribed.clear();
    for (long k = std::max(0L, -start); k < std::min(count, samples - start); k += step) {
      const auto at = static_cast<std::size_t>(start + k);
      if (!is_measured[at]) continue;
      played.push_back(measured[at]);
      prescribed.push_back(expected[static_cast<std::size_t>(k)]);
    }
    if (static_cast<double>(std::ssize(played) * step) < min_fraction * static_cast<double>(count)) continue;
    const double found = correlation(played, prescribed);
    const double explained = found * found * static_cast<double>(played.size());
    if (explained <= largest) continue;
    largest = explained;
    start_s = static_cast<double>(start) / rate_hz;
  }
  return start_s;
}

Match fill_as_prescribed(Recording& recording, const std::vector<double>& expected, double start_s, double from_hz,
                         double rate_hz) {
  std::vector<double>& tilt = recording.signals.at(platform_tilt).rad;
  const double last = static_cast<double>(expected.size() - 1);
  const auto place_of = [&](std::size_t k) { return (static_cast<double>(k) / from_hz - start_s) * rate_hz; };
  const auto expected_at = [&](std::size_t k) {
    const double place = std::clamp(place_of(k), 0.0, last), below = std::min(std::floor(place), last - 1.0);
    const auto i = static_cast<std::size_t>(below);
    return expected[i] + (place - below) * (expected[i + 1] - expected[i]);
  };
  std::vector<double> played, prescribed;  // measured samples within the protocol
  std::size_t k = 0;
  const auto keep_until = [&](std::size_t end) {
    for (; k < end; ++k) {
      if (place_of(k) < 0.0 || place_of(k) > last) continue;
      played.push_back(tilt[k]);
      prescribed.push_back(expected_at(k));
    }
  };
  for (const SampleRange& gap : recording.tilt_gaps) {
    keep_until(gap.first);
    k = gap.end;
  }
  keep_until(tilt.size());
  Match match{start_s * rate_hz, 0.0, 0.0};
  if (played.size() < 2) return match;
  match.correlation = correlation(played, prescribed);
  const double spread = stddev(prescribed);
  if (spread > 0.0) match.gain = match.correlation * stddev(played) / spread;
  const double offset = mean(played) - match.gain * mean(prescribed);
  for (const SampleRange& gap : recording.tilt_gaps)
    for (std::size_t i = gap.first; i < gap.end; ++i) tilt[i] = offset + match.gain * expected_at(i);
  return match;
}

}  // namespace decid::recording
