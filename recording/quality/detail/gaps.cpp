// Stretches that were not measured: see gaps.hpp.
#include "recording/quality/detail/gaps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/math/statistics.hpp"

namespace decid::recording {
namespace {

constexpr double min_stretch_s = 0.1, usual_runs = 12.0;
constexpr double min_median_bend = 10.0, min_median_change = 10.0;  // of the rounding, of the smallest change
constexpr std::size_t min_stretch_samples = 5;

double min_length(double rate_hz) {
  return std::max(static_cast<double>(min_stretch_samples), min_stretch_s * rate_hz);
}

/// Returns the length from which a run is no chance. It counts the median length of a run, weighted by its samples; the
/// longest run does not count. The median is 1 for most recordings.
double min_run(const std::vector<SampleRange>& runs, std::size_t samples, double rate_hz) {
  std::vector<std::size_t> lengths;
  for (const SampleRange& run : runs) lengths.push_back(run.size());
  std::size_t usual = 1;
  if (!lengths.empty()) {
    std::ranges::sort(lengths);
    const std::size_t others = samples - lengths.back();
    if (2 * static_cast<std::size_t>(std::ranges::count(lengths, std::size_t{1})) < others)
      for (std::size_t i = 0, counted = 0; 2 * counted < others; counted += usual) usual = lengths[i++];
  }
  return std::max(min_length(rate_hz), usual_runs * static_cast<double>(usual - 1));
}

/// Returns the runs in which neighbours agree: is_same(k): sample k belongs to the run of sample k - 1.
template <class IsSame>
std::vector<SampleRange> runs_of(std::size_t samples, const IsSame& is_same) {
  std::vector<SampleRange> runs;
  for (std::size_t begin = 0, k = 1; k <= samples; ++k) {
    if (k < samples && is_same(k)) continue;
    runs.push_back({begin, k});
    begin = k;
  }
  return runs;
}

}  // namespace

std::vector<SampleRange> frozen_stretches(std::span<const double> sway, double rate_hz) {
  if (sway.empty()) return {};
  std::vector<SampleRange> runs = runs_of(sway.size(), [&](std::size_t k) { return sway[k] == sway[k - 1]; });
  const double shortest = min_run(runs, sway.size(), rate_hz);
  std::erase_if(runs, [&](const SampleRange& run) {
    return static_cast<double>(run.size()) < shortest || (run.first == 0 && sway[0] == 0.0);
  });
  return runs;
}

std::vector<SampleRange> straight_stretches(std::span<const double> sway, double rate_hz) {
  if (sway.size() < 3) return {};
  // Rounding bends a line by up to two steps of the file, or by the precision of floats.
  double step = std::numeric_limits<double>::infinity(), largest = 0.0;
  for (std::size_t k = 1; k < sway.size(); ++k) {
    if (const double apart = std::abs(sway[k] - sway[k - 1]); apart > 0.0) step = std::min(step, apart);
    largest = std::max(largest, std::abs(sway[k]));
  }
  const double allowed =
      std::max(2.0 * (1.0 + 1e-6) * step, 3.0 * largest * double{std::numeric_limits<float>::epsilon()});
  // bend k: of sample k + 1 between its neighbours.
  const std::size_t bends = sway.size() - 2;
  const auto bend = [&](std::size_t k) { return std::abs(sway[k] - 2.0 * sway[k + 1] + sway[k + 2]); };
  std::vector<double> all(bends);
  for (std::size_t k = 0; k < bends; ++k) all[k] = bend(k);
  if (median(std::move(all)) < min_median_bend * allowed)
    return {};  // coarse, smooth or interpolated: it has such lines
  const auto is_straight = [&](std::size_t k) { return bend(k) <= allowed; };
  std::vector<SampleRange> runs = runs_of(bends, [&](std::size_t k) { return is_straight(k) && is_straight(k - 1); });
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

std::vector<SampleRange> unmeasured_stretches(std::span<const double> sway, double rate_hz) {
  std::vector<SampleRange> stretches = straight_stretches(sway, rate_hz);
  if (sway.size() < 3) return stretches;
  double step = std::numeric_limits<double>::infinity();
  std::vector<double> changes;
  for (std::size_t k = 1; k < sway.size(); ++k) {
    changes.push_back(std::abs(sway[k] - sway[k - 1]));
    if (changes.back() > 0.0) step = std::min(step, changes.back());
  }
  if (median(std::move(changes)) >= min_median_change * step)
    for (const SampleRange& still : frozen_stretches(sway, rate_hz)) stretches.push_back({still.first + 1, still.end});
  return joined(std::move(stretches));
}

std::vector<SampleRange> joined(std::vector<SampleRange> ranges) {
  std::ranges::sort(ranges, {}, &SampleRange::first);
  std::vector<SampleRange> all;
  for (const SampleRange& range : ranges) {
    if (!all.empty() && range.first <= all.back().end)
      all.back().end = std::max(all.back().end, range.end);
    else
      all.push_back(range);
  }
  return all;
}

}  // namespace decid::recording
