// The kinds of layers in training, one file each, and what they share. Formulas in the kernels' table.
// Not installed.
#pragma once

#include <algorithm>

#include "nn/sharing.hpp"
#include "nn/training_layer.hpp"

namespace decid::nn {

template <class T>
std::unique_ptr<TrainingLayer<T>> make_training(Layer<T>& layer, const Conv2d& conv, int largest_batch);
template <class T>
std::unique_ptr<TrainingLayer<T>> make_training(Layer<T>& layer, const FullyConnected& fc, int largest_batch);
/// `before`, unless null, takes the sums of forward if it can.
template <class T>
std::unique_ptr<TrainingLayer<T>> make_training(Layer<T>& layer, const BatchNorm& norm, int largest_batch,
                                                TrainingLayer<T>* before);
template <class T>
std::unique_ptr<TrainingLayer<T>> make_training(Layer<T>& layer, const Relu& relu);
template <class T>
std::unique_ptr<TrainingLayer<T>> make_training(Layer<T>& layer, const Pool& pool);
template <class T>
std::unique_ptr<TrainingLayer<T>> make_training(Layer<T>& layer, const StatisticsPool& pool);

/// A parameter's gradient from the blocks' parts of it, which it uses up.
template <class T>
void sum_gradient(AlignedBuffer<T>& parts, int blocks, std::vector<T>& gradient) {
  const std::size_t size = gradient.size();
  for_each_group(1, static_cast<int>(size), value_group, [&](int, int first, int last) {
    tree_sum(parts.data() + first, blocks, size, static_cast<std::size_t>(last - first));
    std::copy_n(parts.data() + first, last - first, gradient.data() + first);
  });
}

}  // namespace decid::nn
