// Tests of nn/training/batch_partition.hpp: sums in parts, by any number of ranks, are the tree that one has, addition
// for addition.
#include "nn/training/batch_partition.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>
#include <string>

#include "nn/kernels/kernels.hpp"

using namespace decid::nn;

namespace {

/// A sum that remembers how it was made.
struct Sum {
  std::string text;
  Sum& operator+=(const Sum& other) {
    text = "(" + text + " " + other.text + ")";
    return *this;
  }
};

std::vector<Sum> leaves(const std::vector<int>& blocks) {
  std::vector<Sum> sums;
  for (const int block : blocks) sums.push_back({std::to_string(block)});
  return sums;
}

std::string alone(int blocks) {
  std::vector<int> all(static_cast<std::size_t>(blocks));
  std::iota(all.begin(), all.end(), 0);
  std::vector<Sum> sums = leaves(all);
  tree_sum(sums.data(), blocks, 1, 1);
  return sums.front().text;
}

/// Returns the sum that all ranks have at the end.
std::string together(int blocks, int ranks) {
  std::vector<Sum> roots;
  for (int rank = 0; rank < ranks; ++rank) {
    const BatchPartition partition = make_partition(blocks, rank, ranks);
    std::vector<Sum> own = leaves(partition.blocks);
    add_up(partition.own, own.data(), 1, 1);
    CHECK(static_cast<int>(partition.roots.size()) == partition.root_counts[static_cast<std::size_t>(rank)]);
    for (const int root : partition.roots) roots.push_back(own[static_cast<std::size_t>(root)]);
  }
  const BatchPartition partition = make_partition(blocks, ranks - 1, ranks);
  CHECK(static_cast<int>(roots.size()) == partition.root_count());
  add_up(partition.all, roots.data(), 1, 1);
  return roots[static_cast<std::size_t>(partition.total)].text;
}

}  // namespace

TEST_CASE("make_partition: any number of ranks adds up the tree of one") {
  for (int blocks = 1; blocks <= 40; ++blocks)
    for (const int ranks : {1, 2, 3, 4, 5, 7, 8, 16, 41}) {
      CAPTURE(blocks);
      CAPTURE(ranks);
      CHECK(together(blocks, ranks) == alone(blocks));
    }
}

TEST_CASE("make_partition: every block has one owner, shares differ by a block, and little travels") {
  for (const int blocks : {1, 4, 17, 32, 256})
    for (const int ranks : {1, 2, 3, 8, 16}) {
      CAPTURE(blocks);
      CAPTURE(ranks);
      std::vector<int> all;
      int least = blocks, most = 0;
      for (int rank = 0; rank < ranks; ++rank) {
        const BatchPartition partition = make_partition(blocks, rank, ranks);
        CHECK(std::ranges::is_sorted(partition.blocks));
        for (const int block : partition.blocks) CHECK(partition.owner[static_cast<std::size_t>(block)] == rank);
        all.insert(all.end(), partition.blocks.begin(), partition.blocks.end());
        least = std::min(least, static_cast<int>(partition.blocks.size()));
        most = std::max(most, static_cast<int>(partition.blocks.size()));
        // Powers of two: one subtree. Otherwise at most two a level.
        const bool powers = (blocks & (blocks - 1)) == 0 && (ranks & (ranks - 1)) == 0;
        CHECK(partition.roots.size() <= (powers ? 1 : 14));
      }
      std::ranges::sort(all);
      CHECK(static_cast<int>(all.size()) == blocks);
      CHECK(std::ranges::adjacent_find(all) == all.end());
      CHECK(most - least <= 1);
      CHECK(most == max_blocks(blocks, ranks));
    }
}
