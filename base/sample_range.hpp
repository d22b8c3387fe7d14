// Ranges of samples of a signal.
#pragma once

#include <algorithm>
#include <cstddef>
#include <type_traits>
#include <vector>

namespace decid {

/// Samples first .. end - 1.
struct SampleRange {
  std::size_t first = 0, end = 0;
  std::size_t size() const noexcept { return end - first; }
  bool operator==(const SampleRange&) const = default;
  template <class Archive>
  void archive(Archive& a) {
    a(first, end);
  }
};

/// Returns the ranges in ascending order, joined where they touch or overlap.
inline std::vector<SampleRange> joined_ranges(std::vector<SampleRange> ranges) {
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

/// Replaces the values of a range, floats or doubles, by the straight line between their neighbours, at an end by the
/// nearest value, and if the range is all values by 0. The range lies within the values.
template <class Values>
void bridge(Values&& values, const SampleRange& range) {
  using Value = std::remove_cvref_t<decltype(values[0])>;
  static_assert(std::is_floating_point_v<Value>);
  const bool begins = range.first == 0, ends = range.end == values.size();
  const Value after = ends ? (begins ? Value{0} : values[range.first - 1]) : values[range.end];
  const Value before = begins ? after : values[range.first - 1];
  const Value rise = (after - before) / static_cast<Value>(range.size() + 1);
  for (std::size_t k = range.first; k < range.end; ++k)
    values[k] = before + rise * static_cast<Value>(k - range.first + 1);
}

}  // namespace decid
