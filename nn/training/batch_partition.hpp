// Partition of a batch's blocks of 16 samples among processes. Sums of the parts combine to sums of the whole batch
// with the bits of tree_sum (kernels/kernels.hpp).
//
// Read the blocks in the order of their reversed bits, and tree_sum is an ordinary tree over neighbours. A process has
// a run of neighbours, so it sums the subtrees that it holds completely; only their roots travel. There is one root if
// the numbers of blocks and processes are powers of two, otherwise at most two per level. The tree above them is the
// same for every number of processes.
#pragma once

#include <cstddef>
#include <vector>

namespace decid::nn {

/// One rank's part of a batch.
struct BatchPartition {
  /// to += from.
  struct Addition {
    int to, from;
  };
  std::vector<int> owner;        ///< the rank of each block of the batch
  std::vector<int> blocks;       ///< this rank's, ascending; the batch's last, which may be partly filled, comes last
  std::vector<Addition> own;     ///< of places in `blocks`
  std::vector<int> roots;        ///< places whose sums travel, after these additions
  std::vector<int> root_counts;  ///< how many of each rank
  std::vector<Addition> all;     ///< of the roots, counted through the ranks
  int total = 0;                 ///< the root that has the sum of the batch after these

  int root_count() const;
};

/// Returns the partition that a rank, 0 .. ranks - 1, has of a batch of `blocks` blocks. Empty for less than one block;
/// a rank has no blocks if there are more ranks.
BatchPartition make_partition(int blocks, int rank, int ranks);

/// Returns the maximum number of blocks of a rank for batches of up to `blocks`.
inline int max_blocks(int blocks, int ranks) {
  return (blocks + ranks - 1) / ranks;
}

/// Additions of parts of `size` values, `stride` values apart.
template <class T>
void add_up(const std::vector<BatchPartition::Addition>& additions, T* parts, std::size_t stride, std::size_t size) {
  for (const BatchPartition::Addition& addition : additions) {
    T* const to = parts + static_cast<std::size_t>(addition.to) * stride;
    const T* const from = parts + static_cast<std::size_t>(addition.from) * stride;
    for (std::size_t k = 0; k < size; ++k) to[k] += from[k];
  }
}

}  // namespace decid::nn
