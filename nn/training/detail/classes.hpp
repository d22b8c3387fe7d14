// The checks of a classifier's outputs and targets, for losses and accuracy().
#pragma once

#include <cmath>

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

/// Throws Error, naming where(), for a target that is no class of a network with `outputs`.
template <class Where>
void require_class(double target, int outputs, const Where& where) {
  if (target >= 0 && target < outputs && target == std::floor(target)) return;
  throw Error(Code::setting_out_of_range, where(),
              format("has class %g as a target where the network has %d outputs", target, outputs),
              format("number classes from 0 to %d", outputs - 1));
}

}  // namespace decid::nn
