// Ranges of samples of a signal.
#pragma once

#include <algorithm>
#include <cstddef>
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

}  // namespace decid
