// The order of an epoch's samples and the batches that it is cut into: for trainings of every kind.
#pragma once

#include <cstdint>
#include <vector>

namespace decid {

/// Returns 0 .. count - 1 in the order of epoch `epoch`: Fisher and Yates, from (seed, Stream::shuffle, epoch).
std::vector<int> shuffled(int count, std::uint64_t seed, int epoch);

/// The batches of an epoch: as few as hold at most `max_size` samples each, of sizes that differ by 1 at most, the
/// larger ones first. A last batch of what is left over could be of one sample, whose batch statistics say nothing.
class EpochBatches {
 public:
  /// Throws Error if samples or max_size < 1.
  EpochBatches(int samples, int max_size);

  int count() const { return count_; }
  /// The sample that a batch begins with, in the epoch's order; of batch count() the number of samples.
  int first(int batch) const { return batch * min_size_ + (batch < larger_count_ ? batch : larger_count_); }
  int size(int batch) const { return first(batch + 1) - first(batch); }
  int min_size() const { return min_size_; }
  /// The batch that begins with sample `first`, from 0. Throws Error if none does.
  int beginning_at(int first) const;

 private:
  int count_, min_size_, larger_count_;  // the first larger_count_ ones have a sample more
};

}  // namespace decid
