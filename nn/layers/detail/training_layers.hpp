// The kinds of layers in training, one file each, and their shared code. Formulas in the kernels' table. Not installed.
#pragma once

#include <algorithm>
#include <initializer_list>

#include "nn/layers/training_layer.hpp"
#include "nn/training/sharing.hpp"

namespace decid::nn {

template <class T>
std::unique_ptr<TrainingLayer<T>> make_training(Layer<T>& layer, const Conv2d& conv, int max_batch);
template <class T>
std::unique_ptr<TrainingLayer<T>> make_training(Layer<T>& layer, const FullyConnected& fc, int max_batch);
/// `before`, unless null, takes the sums of forward if it can.
template <class T>
std::unique_ptr<TrainingLayer<T>> make_training(Layer<T>& layer, const BatchNorm& norm, int max_batch,
                                                TrainingLayer<T>* before);
/// `before`, unless null, is asked whether it needs its output.
template <class T>
std::unique_ptr<TrainingLayer<T>> make_training(Layer<T>& layer, const Relu& relu, const TrainingLayer<T>* before);
template <class T>
std::unique_ptr<TrainingLayer<T>> make_training(Layer<T>& layer, const Pool& pool);
template <class T>
std::unique_ptr<TrainingLayer<T>> make_training(Layer<T>& layer, const StatisticsPool& pool);
/// The beginning of a block pushes its shared data on `open`, and the end pops it.
template <class T>
std::unique_ptr<TrainingLayer<T>> make_training(Layer<T>& layer, const Branch& branch, int max_batch,
                                                OpenSkips<T>& open);
template <class T>
std::unique_ptr<TrainingLayer<T>> make_training(Layer<T>& layer, const Join& join, OpenSkips<T>& open);
template <class T>
std::unique_ptr<TrainingLayer<T>> make_training(Layer<T>& layer, const Extension& extension, int max_batch);

/// A layer's gradients from the blocks' parts of them, which are used up; with a all_reduce, begins to sum them.
template <class T>
void sum_gradients(std::span<const typename AllReduce<T>::Gradient> gradients, int blocks, AllReduce<T>* all_reduce) {
  if (all_reduce != nullptr) return all_reduce->start(gradients);
  for (const auto& of : gradients) {
    const std::size_t size = of.gradient.size();
    for_each_group(1, static_cast<int>(size), value_group, [&](int, int first, int last) {
      tree_sum(of.parts + first, blocks, size, static_cast<std::size_t>(last - first));
      std::copy_n(of.parts + first, last - first, of.gradient.data() + first);
    });
  }
}
template <class T>
void sum_gradients(std::initializer_list<typename AllReduce<T>::Gradient> gradients, int blocks,
                   AllReduce<T>* all_reduce) {
  sum_gradients<T>(std::span(gradients.begin(), gradients.size()), blocks, all_reduce);
}

}  // namespace decid::nn
