// The check of a classifier's outputs, for losses and accuracy().
#pragma once

#include "base/error.hpp"
#include "base/text.hpp"
#include "nn/tensor.hpp"

namespace decid::nn {

/// Throws Error, naming `where`, for outputs that are not one value per class.
inline void require_classes(const Shape& output, const char* where) {
  if (output.rows == 1 && output.columns == 1) return;
  throw Error(
      Code::size_mismatch, where,
      format("has outputs of %d x %d x %d values, not one per class", output.channels, output.rows, output.columns),
      "end the network with fc or globalavgpool");
}

}  // namespace decid::nn
