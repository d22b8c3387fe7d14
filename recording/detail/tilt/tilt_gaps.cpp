// Gaps of a measured tilt: see tilt_gaps.hpp.
#include "recording/detail/tilt/tilt_gaps.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "base/math/statistics.hpp"

namespace decid::recording {
namespace {

constexpr double coarse_hz = 10.0;
/// Measurement noise and gaps change squared correlations, and these times the samples, by less.
constexpr double same_squared = 0.98, same_explained = 0.9;

/// The protocol's tilt at the samples of a recording, between its own samples by straight lines.
struct Prescribed {
  const std::vector<double>& expected;
  double start_s, from_hz, rate_hz;

  double last() const { return static_cast<double>(expected.size() - 1); }
  double place_of(std::size_t k) const { return (static_cast<double>(k) / from_hz - start_s) * rate_hz; }
  bool covers(std::size_t k) const { return place_of(k) >= 0.0 && place_of(k) <= last(); }
  double at(std::size_t k) const {
    const double place = std::clamp(place_of(k), 0.0, last()), below = std::min(std::floor(place), last() - 1.0);
    const auto i = static_cast<std::size_t>(below);
    return expected[i] + (place - below) * (expected[i + 1] - expected[i]);
  }
};

/// The samples of a tilt outside of its gaps.
class Measured {
 public:
  explicit Measured(const Recording& recording) {
    const std::vector<double>& tilt = recording.signals.at(platform_tilt).rad;
    std::size_t k = 0;
    const auto keep_until = [&](std::size_t end) {
      for (; k < end; ++k) {
        samples_.push_back(k);
        rad_.push_back(tilt[k]);
      }
    };
    for (const SampleRange& gap : recording.tilt_gaps) {
      keep_until(gap.first);
      k = gap.end;
    }
    keep_until(tilt.size());
  }

  /// Returns those within the protocol, and the protocol's tilt there; valid until the next call.
  std::pair<std::span<const double>, std::span<const double>> beside(const Prescribed& protocol) {
    prescribed_.clear();
    std::size_t first = 0;
    while (first < samples_.size() && !protocol.covers(samples_[first])) ++first;
    for (std::size_t i = first; i < samples_.size() && protocol.covers(samples_[i]); ++i)
      prescribed_.push_back(protocol.at(samples_[i]));
    return {std::span(rad_).subspan(first, prescribed_.size()), prescribed_};
  }

 private:
  std::vector<std::size_t> samples_;
  std::vector<double> rad_, prescribed_;
};

/// Returns the start of the largest correlation of measured samples, at most `reach` samples of the protocol from
/// another start.
double refined_start(const Recording& recording, const std::vector<double>& expected, double start_s, long reach,
                     double from_hz, double rate_hz) {
  const auto start_of = [&](double samples) { return start_s + samples / rate_hz; };
  Measured measured(recording);
  std::vector<double> found;
  for (long lag = -reach; lag <= reach; ++lag) {
    const auto [played, prescribed] = measured.beside({expected, start_of(static_cast<double>(lag)), from_hz, rate_hz});
    found.push_back(played.size() < 2 ? 0.0 : std::abs(correlation(played, prescribed)));
  }
  const auto best = std::ranges::max_element(found);
  const auto lag = static_cast<double>(best - found.begin() - reach);
  if (best == found.begin() || best + 1 == found.end()) return start_of(lag);
  const double before = *(best - 1), after = *(best + 1), curvature = before - 2.0 * *best + after;
  const double between = curvature < 0.0 ? std::clamp(0.5 * (before - after) / curvature, -0.5, 0.5) : 0.0;
  return start_of(lag + between);
}

/// Returns the start to one part in coarse_hz of a second; empty with too few measured samples at each start.
std::optional<double> coarse_start(const std::vector<double>& measured, const std::vector<SampleRange>& gaps,
                                   const std::vector<double>& expected, long step, double from_hz, double rate_hz) {
  constexpr double min_fraction = 0.4;
  const long count = std::ssize(expected);
  const long overhang = count / 4, samples = std::ssize(measured);
  std::vector<bool> is_measured(measured.size(), true);
  for (const SampleRange& gap : gaps) {
    const double first = std::floor(static_cast<double>(gap.first) / from_hz * rate_hz);
    const double end = std::ceil(static_cast<double>(gap.end) / from_hz * rate_hz);
    for (auto k = static_cast<std::size_t>(first); k < std::min(static_cast<std::size_t>(end), measured.size()); ++k)
      is_measured[k] = false;
  }
  // As TiltMatcher, prefers the protocol's own sign; where the recording has the whole protocol, because gaps leave
  // parts of the same size.
  struct Found {
    double explained = 0.0, squared = 0.0;
    std::optional<double> start_s = {};
  };
  Found any, positive;
  std::vector<double> played, prescribed;
  // 0, the start of most recordings, is one of the starts.
  for (long start = -(overhang / step) * step; start <= samples - count + overhang; start += step) {
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
    const double squared = found * found, explained = squared * static_cast<double>(played.size());
    const bool is_whole = start >= 0 && start <= samples - count;
    for (Found* best : {&any, &positive})
      if (explained > best->explained && (best == &any || (found > 0.0 && is_whole)))
        *best = {explained, squared, static_cast<double>(start) / rate_hz};
  }
  const bool has_sign =
      positive.explained >= same_explained * any.explained && positive.squared >= same_squared * any.squared;
  return has_sign ? positive.start_s : any.start_s;
}

}  // namespace

double start_beside_gaps(const Recording& recording, const std::vector<double>& measured,
                         const std::vector<double>& expected, double from_hz, double rate_hz) {
  const long step = std::max(1L, std::lround(rate_hz / coarse_hz));
  const std::optional<double> start_s = coarse_start(measured, recording.tilt_gaps, expected, step, from_hz, rate_hz);
  return start_s ? refined_start(recording, expected, *start_s, step, from_hz, rate_hz) : 0.0;
}

Match fill_as_prescribed(Recording& recording, const std::vector<double>& expected, double start_s, double from_hz,
                         double rate_hz) {
  const Prescribed protocol{expected, start_s, from_hz, rate_hz};
  Measured measured(recording);
  const auto [played, prescribed] = measured.beside(protocol);
  Match match{start_s * rate_hz, 0.0, 0.0};
  if (played.size() < 2) return match;
  match.correlation = correlation(played, prescribed);
  const double spread = stddev(prescribed);
  if (spread > 0.0) match.gain = match.correlation * stddev(played) / spread;
  const double offset = mean(played) - match.gain * mean(prescribed);
  std::vector<double>& tilt = recording.signals.at(platform_tilt).rad;
  for (const SampleRange& gap : recording.tilt_gaps)
    for (std::size_t i = gap.first; i < gap.end; ++i) tilt[i] = offset + match.gain * protocol.at(i);
  return match;
}

}  // namespace decid::recording
