// Partitions of a batch: see batch_partition.hpp.
#include "nn/training/batch_partition.hpp"

#include <algorithm>
#include <numeric>

#include "base/communicator.hpp"

namespace decid::nn {
namespace {

/// The rank of each block.
std::vector<int> owners(int blocks, int ranks) {
  unsigned bits = 0;
  while ((1U << bits) < static_cast<unsigned>(blocks)) ++bits;
  const auto reversed = [bits](int block) {
    unsigned result = 0;
    for (unsigned bit = 0; bit < bits; ++bit) result = result << 1U | (static_cast<unsigned>(block) >> bit & 1U);
    return result;
  };
  std::vector<int> order(static_cast<std::size_t>(blocks)), owner(order.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, reversed);
  for (int rank = 0; rank < ranks; ++rank) {
    const RankRange range = rank_range(order.size(), rank, ranks);
    for (std::size_t i = range.first; i < range.last; ++i) owner[static_cast<std::size_t>(order[i])] = rank;
  }
  return owner;
}

/// A sum on its way up: of blocks that one rank has, or of roots.
struct Node {
  int owner;  // -1: of several ranks
  int place;  // of the owner's blocks, or of the roots
};

struct Root {
  int owner, place;
};

}  // namespace

int BatchPartition::root_count() const {
  return std::accumulate(root_counts.begin(), root_counts.end(), 0);
}

BatchPartition make_partition(int blocks, int rank, int ranks) {
  BatchPartition partition;
  partition.root_counts.assign(static_cast<std::size_t>(ranks), 0);
  if (blocks < 1) return partition;
  partition.owner = owners(blocks, ranks);
  std::vector<Node> nodes;
  std::vector<int> had(static_cast<std::size_t>(ranks));
  for (int block = 0; block < blocks; ++block) {
    const int own = partition.owner[static_cast<std::size_t>(block)];
    if (own == rank) partition.blocks.push_back(block);
    nodes.push_back({own, had[static_cast<std::size_t>(own)]++});
  }
  // As tree_sum goes; roots are in the order in which they are found, until they are put in that of the ranks.
  std::vector<Root> roots;
  const auto make_root = [&](Node& node) {
    if (node.owner < 0) return;
    roots.push_back({node.owner, node.place});
    node = {-1, static_cast<int>(roots.size()) - 1};
  };
  int half = 1;
  while (half < blocks) half *= 2;
  for (half /= 2; half > 0; half /= 2)
    for (int i = 0; i < half && i + half < blocks; ++i) {
      Node &to = nodes[static_cast<std::size_t>(i)], &from = nodes[static_cast<std::size_t>(i + half)];
      if (to.owner >= 0 && to.owner == from.owner) {
        if (to.owner == rank) partition.own.push_back({to.place, from.place});
        continue;
      }
      make_root(to);
      make_root(from);
      partition.all.push_back({to.place, from.place});
    }
  make_root(nodes.front());

  std::vector<int> order(roots.size()), place(roots.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](int root) { return roots[static_cast<std::size_t>(root)].owner; });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const Root& root = roots[static_cast<std::size_t>(order[i])];
    place[static_cast<std::size_t>(order[i])] = static_cast<int>(i);
    ++partition.root_counts[static_cast<std::size_t>(root.owner)];
    if (root.owner == rank) partition.roots.push_back(root.place);
  }
  for (BatchPartition::Addition& addition : partition.all)
    addition = {place[static_cast<std::size_t>(addition.to)], place[static_cast<std::size_t>(addition.from)]};
  partition.total = place[static_cast<std::size_t>(nodes.front().place)];
  return partition;
}

}  // namespace decid::nn
