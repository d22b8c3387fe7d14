// Inference of a batch of samples, 16 adjacent ones at a time (nn/tensor.hpp). A Predictor runs many images with it.
#pragma once

#include <vector>

#include "nn/inference.hpp"
#include "nn/tensor.hpp"

namespace decid::nn {

/// Runs batches. After construction only these layers allocate: convolutions with groups or dilation, layernorm, and
/// registered layers with parameters. More than one block of 16 samples per thread gains nothing: more activations
/// leave the cache before they are read.
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
  /// Sets the number of samples of the next forward, 1 .. max_batch().
  void set_batch(int batch);
  /// Returns the tensor to load the samples into before each forward().
  TensorView<T> input() { return tensors_.front(); }
  void forward();
  TensorView<const T> output() const { return tensors_.back(); }
  /// Returns the input of the last step.
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
