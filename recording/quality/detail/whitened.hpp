// The innovations of an autoregression. Not installed.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace decid::recording {

/// Returns values[k] - sum_i a[i] values[k - 1 - i], with zeros before the first value.
inline std::vector<double> whitened(std::span<const double> values, std::span<const double> a) {
  std::vector<double> result(values.begin(), values.end());
  for (std::size_t k = 0; k < values.size(); ++k)
    for (std::size_t i = 0; i < std::min(k, a.size()); ++i) result[k] -= a[i] * values[k - 1 - i];
  return result;
}

}  // namespace decid::recording
