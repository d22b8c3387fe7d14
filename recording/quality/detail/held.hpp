// Values that are held: samples of a slow sensor, repeated to the rate of the file. Not installed.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace decid::recording {

struct Held {
  std::size_t samples = 1;  ///< that each value lasts; 1: none is held
  std::size_t first = 0;    ///< the first sample at which a value begins

  bool is_held() const { return samples > 1; }
  /// Returns the first sample of each value; also of one that began before `first`.
  std::vector<double> values_of(std::span<const double> sway) const;
};

/// Finds runs of equal samples that all begin at multiples of one number of samples from each other. At least half of
/// these places must have another value than before: a stretch that stands still holds nothing.
Held find_held(std::span<const double> sway);

}  // namespace decid::recording
