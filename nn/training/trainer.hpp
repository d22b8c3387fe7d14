// Training of a network: forward and backward over batches. A Trainer owns all training data except the weights and the
// optimiser's memory: gradients, activations, scratch.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "nn/network.hpp"
#include "nn/tensor.hpp"

namespace decid {
class Communicator;
}

namespace decid::nn {

template <class T>
class TrainingLayer;
template <class T>
class AllReduce;

/// One step: load input(), forward(), put the loss's derivative into output_diff(), backward(), then update() of
/// nn/training/optimiser.hpp with gradients(). After construction only these allocate: threads that join later, once
/// each; convolutions with groups or dilation; sums over other processes.
template <class T>
class Trainer {
 public:
  /// Prepares steps of up to `max_batch` samples, 1 .. 65536. The network must outlive the trainer and stay in its
  /// place; forward() moves its running statistics. ranks, unless null: the processes that share each batch, all of
  /// which make the same calls. A rank has the samples of some blocks of 16 (own_samples()). Weights, statistics and
  /// gradients belong to the whole batch; they are equal at every rank, with the bits of a single process.
  /// with_input_diff: backward() also leaves the derivative by the input.
  Trainer(Network<T>& network, int max_batch, Communicator* ranks = nullptr, bool with_input_diff = false);
  Trainer(Trainer&&) noexcept;
  ~Trainer();

  const Network<T>& network() const { return network_; }
  int max_batch() const { return max_batch_; }
  /// Returns the bytes of activations and their derivatives.
  std::size_t memory_bytes() const { return memory_.size() * sizeof(T); }
  /// Sets the samples of the next step, 1 .. max_batch(), of all ranks together. Throws Error, as the constructor does,
  /// for a batch of 1 if a BatchNorm then has a single value per channel.
  void set_batch(int batch);
  /// Returns the samples of a batch that this rank loads, ascending, 16 of a block together: all for a single process.
  /// It may return none.
  std::vector<int> own_samples(int batch) const;

  /// Returns the tensors of inputs and outputs, with own_samples() samples. Load the samples into input().
  TensorView<T> input() { return activations_.front(); }
  TensorView<T> output() { return activations_.back(); }
  TensorView<const T> output() const { return activations_.back(); }
  /// Returns the tensor for d loss / d output, to fill before backward().
  TensorView<T> output_diff() { return differences_.back(); }

  /// Returns d loss / d input after backward(), if the trainer was made with with_input_diff.
  TensorView<const T> input_diff() const { return differences_.front(); }

  /// Sets the random numbers of layers that draw some (dropout) to those of (seed, step). Without this call they draw
  /// none. Equal numbers give equal masks, for any number of threads and ranks.
  void set_random(std::uint64_t seed, std::uint64_t step);
  /// Makes BatchNorm normalise by its running statistics, as in inference, and leave them, from now on. A batch of 1 is
  /// then allowed.
  void freeze_statistics();
  /// Runs the forward pass with the batch's statistics in BatchNorm.
  void forward();
  /// Computes the gradients of all parameters from output_diff(), which it overwrites.
  void backward();

  /// Returns d loss / d parameter, by the parameter's index in network().parameters(); shaped as its value. Throws
  /// Error if there is no such parameter.
  std::span<T> gradient(std::size_t parameter);
  std::span<const T> gradient(std::size_t parameter) const;
  /// Returns gradient() of all parameters.
  std::vector<std::span<const T>> gradients() const { return {gradients_.begin(), gradients_.end()}; }

 private:
  void plan();
  Halo activation_halo(std::size_t index) const;
  Halo difference_halo(std::size_t index) const;
  bool difference_replaces_activation(std::size_t index) const;

  Network<T>& network_;
  int max_batch_;
  Communicator* ranks_;
  bool with_input_diff_;
  bool frozen_statistics_ = false;
  int own_batch_;                             // the largest of this rank
  std::unique_ptr<AllReduce<T>> all_reduce_;  // with other ranks
  std::vector<std::unique_ptr<TrainingLayer<T>>> layers_;
  std::vector<std::span<T>> gradients_;  // the layers'
  AlignedBuffer<T> memory_;
  std::vector<TensorView<T>> activations_;  // [0] the input, [i + 1] the output of layer i
  std::vector<TensorView<T>> differences_;  // the loss's derivative by each of them
};

}  // namespace decid::nn
