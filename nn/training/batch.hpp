// A batch of samples through the steps of inference, 16 of them side by side (nn/tensor.hpp): what a Predictor runs
// many images with.
#pragma once

#include <vector>

#include "nn/inference.hpp"
#include "nn/tensor.hpp"

namespace decid::nn {

/// Takes its memory when it is made. Samples beyond a block of 16 for each thread gain nothing: more activations leave
/// the cache before they are read.
template <class T>
class BatchExecutor {
 public:
  /// `inference` must outlive it.
  BatchExecutor(const Inference<T>& inference, int max_batch);

  int max_batch() const { return max_batch_; }
  std::size_t memory_bytes() const {
    std::size_t values = memory_.size() + dense_.size();
    for (const AlignedBuffer<T>& kept : kept_) values += kept.size();
    return values * sizeof(T);
  }
  /// Samples of the next forward, 1 .. max_batch().
  void set_batch(int batch);
  /// Where to load the samples before each forward().
  TensorView<T> input() { return tensors_.front(); }
  void forward();
  TensorView<const T> output() const { return tensors_.back(); }
  /// What the last step read.
  TensorView<const T> features() const { return tensors_[tensors_.size() - 2]; }

 private:
  const Inference<T>& inference_;
  int max_batch_;
  AlignedBuffer<T> memory_;
  std::vector<AlignedBuffer<T>> kept_;  // inputs of residuals and concats, by the depth of the block
  AlignedBuffer<T> dense_;              // outputs of a fully connected layer whose dst has a halo
  std::vector<TensorView<T>> tensors_;  // [0] the input, [i + 1] the output of step i
};

}  // namespace decid::nn
