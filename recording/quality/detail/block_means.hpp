// Means of neighbouring samples. Not installed.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace decid::recording {

/// Returns the mean of each block of `block` neighbouring values; ignores values after the last whole block.
inline std::vector<double> block_means(std::span<const double> values, std::size_t block) {
  std::vector<double> means(values.size() / block);
  for (std::size_t i = 0; i < means.size(); ++i) {
    for (std::size_t k = 0; k < block; ++k) means[i] += values[i * block + k];
    means[i] /= static_cast<double>(block);
  }
  return means;
}

}  // namespace decid::recording
