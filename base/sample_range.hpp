// A range of samples of a signal.
#pragma once

#include <cstddef>

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

}  // namespace decid
