// Fusion in training: a convolution takes the sums of the BatchNorm behind it while the rows that it has just written
// are in the cache. (make_layers fuses BatchNorm with ReLU and pool; inference folds it into weights.)
#pragma once

#include <algorithm>
#include <cstddef>

#include "nn/layers/layer.hpp"
#include "nn/training/all_reduce.hpp"

namespace decid::nn {

/// A BatchNorm's two sums per channel over a batch, in double: in each lane row after row, then over the lanes of a
/// block, then over the blocks, by the trees of kernels.hpp. The bits do not depend on the layer that computes them.
template <class T>
class BatchSums {
 public:
  /// `running_mean`: the forward sums are taken around it, and it must outlive this.
  BatchSums(const RunningStatistics<T>& running_mean, int max_batch)
      : running_mean_(running_mean), channels_(running_mean.value.size()) {
    parts_.reserve(std::max<std::size_t>(TensorView<T>::count_blocks(max_batch), 1) * channels_ * 2);
  }

  /// Forward: adds rows of a channel to its sums of each lane, `sums` (2 x lanes); calls in order of rows.
  void add_rows(Plane<const T> rows, int channel, double* sums) const {
    kernels<T>().batchnorm_sums(rows, running_mean_.value[static_cast<std::size_t>(channel)], sums);
  }
  /// Keeps the sums of a whole plane, of which `valid` lanes hold samples.
  void keep(const double* sums, int valid, int block, int channel) {
    double* const part =
        parts_.data() + (static_cast<std::size_t>(block) * channels_ + static_cast<std::size_t>(channel)) * 2;
    part[0] = lane_sum(sums, valid);
    part[1] = lane_sum(sums + lanes, valid);
  }
  /// When all planes of `blocks` blocks are kept: both sums of channel 0, of channel 1, ...; with a reducer, over those
  /// of all processes.
  const double* total(int blocks, AllReduce<T>* all_reduce) {
    if (all_reduce != nullptr)
      all_reduce->sum(parts_.data(), channels_ * 2);
    else
      tree_sum(parts_.data(), blocks, channels_ * 2, channels_ * 2);
    return parts_.data();
  }

 private:
  const RunningStatistics<T>& running_mean_;
  std::size_t channels_;
  AlignedBuffer<double> parts_;  // two sums per block and channel
};

}  // namespace decid::nn
