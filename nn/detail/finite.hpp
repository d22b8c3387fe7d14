// Values that are neither infinite nor NaN. Not installed.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

namespace decid::nn {

/// Returns false if a value is infinite or NaN.
template <class T>
bool is_finite(std::span<const T> values) {
  return std::ranges::all_of(values, [](T value) { return std::isfinite(value); });
}
inline bool is_finite(std::span<const float> values) {
  return is_finite<float>(values);
}

}  // namespace decid::nn
