// Sums over a batch whose blocks several processes share (nn/training/batch_partition.hpp), with the bits of a single
// process. Gradients are summed while the layers before theirs are still computed.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "base/communicator.hpp"
#include "nn/training/batch_partition.hpp"

namespace decid::nn {

/// Every rank makes the same calls in the same order.
template <class T>
class AllReduce {
 public:
  /// `ranks` must outlive it.
  explicit AllReduce(Communicator& ranks) : ranks_(ranks) {}

  /// Sets the samples of the next step, of all ranks together.
  void set_batch(int batch);
  int batch() const { return batch_; }
  const BatchPartition& partition() const { return *partition_; }

  /// parts: `size` values for each of partition().blocks, and room for one if there is none. The first gets the sum
  /// over the batch.
  void sum(double* parts, std::size_t size);

  /// A parameter's: parts, gradient.size() values for each of partition().blocks, are used up.
  struct Gradient {
    T* parts;
    std::span<T> gradient;
  };
  /// Begins to sum a layer's. `gradients` and what they refer to must stay until finish().
  void start(std::span<const Gradient> gradients);
  /// Advances the sums that are under way.
  void progress();
  /// Waits until all sums that were begun are complete.
  void finish();

 private:
  /// A layer's gradients in exchange. Each rank gets the roots of its shard of the values, adds them up and sends the
  /// sums to all. Small gradients go to all ranks at once.
  struct Sum {
    std::vector<Gradient> gradients;
    std::size_t values = 0;
    bool whole = false;  // every rank adds up all values
    std::vector<T> sent, received, own, all;
    std::unique_ptr<Communicator::Transfer> exchange, gather;
  };

  RankRange shard(const Sum& sum, int rank) const;
  void pack(Sum& sum) const;
  /// After the exchange.
  void add_up_shard(Sum& sum);
  static void unpack(const Sum& sum, const std::vector<T>& values);

  Communicator& ranks_;
  int batch_ = 0;
  const BatchPartition* partition_ = nullptr;
  std::map<int, BatchPartition> partitions_;  // by the batch's blocks
  std::vector<double> sent_, received_;
  std::vector<std::unique_ptr<Sum>> sums_;  // of a step, kept for their memory
  std::size_t begun_ = 0, exchanged_ = 0;   // of them
};

}  // namespace decid::nn
