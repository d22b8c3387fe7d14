// The input that the beginning of a residual or concat keeps for its end in training, and the derivative that the end
// returns.
#pragma once

#include <memory>
#include <vector>

#include "nn/tensor.hpp"

namespace decid::nn {

template <class T>
class Skip {
 public:
  Skip(Shape shape, int max_batch) : shape_(shape) { memory_.reserve(TensorView<T>::required(shape, max_batch, {})); }
  TensorView<const T> kept;  ///< the beginning's input, which stays until backward
  /// Returns the derivative by the kept input that bypasses the block.
  TensorView<T> diff(int batch) { return {memory_.data(), shape_, batch, {}}; }

 private:
  Shape shape_;
  AlignedBuffer<T> memory_;
};

/// The skips of the open blocks, the innermost last.
template <class T>
using OpenSkips = std::vector<std::shared_ptr<Skip<T>>>;

}  // namespace decid::nn
