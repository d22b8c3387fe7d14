// Stretches that were not measured: see gaps.hpp.
#include "recording/quality/detail/gaps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace decid::recording {
namespace {

constexpr double min_stretch_s = 0.1, usual_runs = 12.0;
constexpr double min_median_bend = 10.0, min_median_change = 10.0;  // of the rounding, of the smallest change
constexpr std::size_t min_stretch_samples = 5;
/// No sway of fewer than 5 samples per second is read: interpolated throughout, it bends more often than once a second.
constexpr double min_surely_bridged_s = 1.0;
constexpr double min_judged_fraction = 0.05;

double min_length(double rate_hz) {
  return std::max(static_cast<double>(min_stretch_samples), min_stretch_s * rate_hz);
}

/// The sizes of a sway that tell a stretch from what its sensor and its file's digits do.
struct Sizes {
  double min_change = std::numeric_limits<double>::infinity();  ///< between neighbours that differ
  double max = 0.0;                                             ///< of the sway
};
Sizes sizes_of(std::span<const double> sway) {
  Sizes sizes;
  for (std::size_t k = 1; k < sway.size(); ++k) {
    if (const double change = std::abs(sway[k] - sway[k - 1]); change > 0.0)
      sizes.min_change = std::min(sizes.min_change, change);
    sizes.max = std::max(sizes.max, std::abs(sway[k]));
  }
  return sizes;
}

/// Returns whether the median of value(0) to value(count - 1) is below a limit, without the values in `ignored`:
/// ascending ranges that are apart.
template <class Value>
bool is_median_below(double limit, std::size_t count, const Value& value, std::span<const SampleRange> ignored) {
  std::size_t below = 0, judged = 0, k = 0;
  const auto judge_until = [&](std::size_t end) {
    for (; k < end; ++k, ++judged) below += value(k) < limit ? 1 : 0;
  };
  for (const SampleRange& range : ignored) {
    judge_until(range.first);
    k = range.end;
  }
  judge_until(count);
  return 2 * below > judged;
}

std::size_t samples_in(std::span<const SampleRange> ranges) {
  std::size_t samples = 0;
  for (const SampleRange& range : ranges) samples += range.size();
  return samples;
}

/// Returns the runs of two samples and more in which neighbours agree: is_same(k): sample k belongs to the run of
/// sample k - 1.
template <class IsSame>
std::vector<SampleRange> runs_of(std::size_t samples, const IsSame& is_same) {
  std::vector<SampleRange> runs;
  for (std::size_t begin = 0, k = 1; k <= samples; ++k) {
    if (k < samples && is_same(k)) continue;
    if (k > begin + 1) runs.push_back({begin, k});
    begin = k;
  }
  return runs;
}

/// Returns the length from which a run is no chance. It counts the median length of a run, weighted by its samples; the
/// longest run does not count. The median is 1 for most recordings. runs: of two samples and more, among `samples`.
double min_run(const std::vector<SampleRange>& runs, std::size_t samples, double rate_hz) {
  std::vector<std::size_t> lengths;
  std::size_t single = samples;
  for (const SampleRange& run : runs) {
    lengths.push_back(run.size());
    single -= run.size();
  }
  std::size_t usual = 1;
  if (!lengths.empty()) {
    std::ranges::sort(lengths);
    const std::size_t others = samples - lengths.back();
    for (std::size_t i = 0, counted = single; 2 * counted < others; counted += usual) usual = lengths[i++];
  }
  return std::max(min_length(rate_hz), usual_runs * static_cast<double>(usual - 1));
}

std::vector<SampleRange> frozen_stretches(std::span<const double> sway, double rate_hz) {
  std::vector<SampleRange> runs = runs_of(sway.size(), [&](std::size_t k) { return sway[k] == sway[k - 1]; });
  const double shortest = min_run(runs, sway.size(), rate_hz);
  std::erase_if(runs, [&](const SampleRange& run) {
    return static_cast<double>(run.size()) < shortest || (run.first == 0 && sway[0] == 0.0);
  });
  return runs;
}

std::vector<SampleRange> straight_stretches(std::span<const double> sway, const Sizes& sizes, double rate_hz) {
  // Rounding bends a line by up to two steps of the file, or by the precision of floats.
  const double allowed =
      std::max(2.0 * (1.0 + 1e-6) * sizes.min_change, 3.0 * sizes.max * double{std::numeric_limits<float>::epsilon()});
  // bend k: of sample k + 1 between its neighbours.
  const std::size_t bends = sway.size() - 2;
  const auto bend = [&](std::size_t k) { return std::abs(sway[k] - 2.0 * sway[k + 1] + sway[k + 2]); };
  const auto is_straight = [&](std::size_t k) { return bend(k) <= allowed; };
  const std::vector<SampleRange> runs =
      runs_of(bends, [&](std::size_t k) { return is_straight(k) && is_straight(k - 1); });
  // Long lines do not decide whether the rest is often straight, unless they leave too few bends to judge.
  std::vector<SampleRange> ignored = runs;
  std::erase_if(ignored, [&](const SampleRange& run) {
    return static_cast<double>(run.size()) < min_surely_bridged_s * rate_hz;
  });
  const double judged = static_cast<double>(bends - samples_in(ignored));
  if (judged < min_judged_fraction * static_cast<double>(bends)) ignored.clear();
  if (is_median_below(min_median_bend * allowed, bends, bend, ignored)) return {};
  const double shortest = min_length(rate_hz);
  std::vector<SampleRange> stretches;
  for (const SampleRange& run : runs) {
    const bool measured_on_both_sides = run.first > 0 && run.end < bends;
    const bool has_slope = std::abs(sway[run.end + 1] - sway[run.first]) > allowed;
    if (static_cast<double>(run.size()) >= shortest && measured_on_both_sides && has_slope)
      stretches.push_back({run.first + 1, run.end + 1});
  }
  return stretches;
}

/// Returns whether a sway usually changes by less than ten of its smallest changes outside of its frozen stretches. At
/// a turn it then stays within a step of the sensor, or of the file's digits, for as long as a frozen sensor stands
/// still.
bool stands_still_by_digits(std::span<const double> sway, double min_change, std::vector<SampleRange> frozen) {
  for (SampleRange& stretch : frozen) --stretch.end;  // change k: from sample k to sample k + 1
  return is_median_below(
      min_median_change * min_change, sway.size() - 1, [&](std::size_t k) { return std::abs(sway[k + 1] - sway[k]); },
      frozen);
}

}  // namespace

Stretches find_stretches(std::span<const double> sway, double rate_hz) {
  if (sway.size() < 3) return {};
  const Sizes sizes = sizes_of(sway);
  Stretches found{frozen_stretches(sway, rate_hz), straight_stretches(sway, sizes, rate_hz), {}};
  found.unmeasured = found.straight;
  if (!found.frozen.empty() && !stands_still_by_digits(sway, sizes.min_change, found.frozen))
    for (const SampleRange& still : found.frozen) found.unmeasured.push_back({still.first + 1, still.end});
  found.unmeasured = joined_ranges(std::move(found.unmeasured));
  return found;
}

}  // namespace decid::recording
