// The order of an epoch's samples, and its batches: see batches.hpp.
#include "base/batches.hpp"

#include <numeric>
#include <string>
#include <utility>

#include "base/error.hpp"
#include "base/math/random.hpp"

namespace decid {

std::vector<int> shuffled(int count, std::uint64_t seed, int epoch) {
  std::vector<int> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  const Random random(seed, Stream::shuffle, static_cast<std::uint64_t>(epoch));
  for (std::size_t i = order.size(); i-- > 1;)
    std::swap(order[i], order[static_cast<std::size_t>(random.below(i, i + 1))]);
  return order;
}

EpochBatches::EpochBatches(int samples, int max_size) {
  if (samples < 1)
    throw Error(Code::setting_out_of_range, "epoch", "of " + std::to_string(samples) + " samples", "give 1 or more");
  if (max_size < 1)
    throw Error(Code::setting_out_of_range, "epoch", "batches of " + std::to_string(max_size) + " samples",
                "ask for 1 or more");
  count_ = 1 + (samples - 1) / max_size;
  min_size_ = samples / count_;
  larger_count_ = samples % count_;
}

int EpochBatches::beginning_at(int first) const {
  for (int batch = 0; batch < count_; ++batch)
    if (this->first(batch) == first) return batch;
  throw Error(Code::setting_out_of_range, "epoch", "no batch begins with sample " + std::to_string(first),
              "give a checkpoint of the same training, begun by this version of decid");
}

}  // namespace decid
