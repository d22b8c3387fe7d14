// What the beginning of a residual or concat keeps for its end in training, and gets back.
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
  /// The derivative by it that goes past the block.
  TensorView<T> diff(int batch) { return {memory_.data(), shape_, batch, {}}; }

 private:
  Shape shape_;
  AlignedBuffer<T> memory_;
};

/// Of the blocks whose end is to come, the innermost last.
template <class T>
using OpenSkips = std::vector<std::shared_ptr<Skip<T>>>;

}  // namespace decid::nn
