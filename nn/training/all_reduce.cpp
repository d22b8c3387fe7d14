// Sums among processes: see all_reduce.hpp.
#include "nn/training/all_reduce.hpp"

#include <algorithm>

#include "nn/tensor.hpp"
#include "nn/training/sharing.hpp"

namespace decid::nn {
namespace {

/// Gradients up to this many bytes cost less if sent whole to every rank than in two rounds.
constexpr std::size_t small_bytes = 4096;

/// Calls body(offset in the values, pointer, count) for each part of the pieces within [first, last).
template <class Pieces, class Pointer, class Body>
void for_each_piece(const Pieces& pieces, RankRange range, const Pointer& pointer_of, const Body& body) {
  std::size_t begin = 0;
  for (const auto& piece : pieces) {
    const std::size_t end = begin + piece.gradient.size();
    const std::size_t first = std::max(begin, range.first), last = std::min(end, range.last);
    if (first < last) body(first, pointer_of(piece) + (first - begin), last - first);
    begin = end;
  }
}

template <class T>
std::vector<std::size_t> bytes_of(const std::vector<std::size_t>& values) {
  std::vector<std::size_t> bytes;
  for (const std::size_t count : values) bytes.push_back(count * sizeof(T));
  return bytes;
}

}  // namespace

template <class T>
void AllReduce<T>::set_batch(int batch) {
  batch_ = batch;
  const int blocks = static_cast<int>(TensorView<T>::count_blocks(batch));
  const auto [found, is_new] = partitions_.try_emplace(blocks);
  if (is_new) found->second = make_partition(blocks, ranks_.rank(), ranks_.size());
  partition_ = &found->second;
}

template <class T>
void AllReduce<T>::sum(double* parts, std::size_t size) {
  add_up(partition_->own, parts, size, size);
  sent_.clear();
  for (const int root : partition_->roots) {
    const double* const values = parts + static_cast<std::size_t>(root) * size;
    sent_.insert(sent_.end(), values, values + size);
  }
  received_.resize(static_cast<std::size_t>(partition_->root_count()) * size);
  std::vector<std::size_t> sizes;
  for (const int roots : partition_->root_counts)
    sizes.push_back(static_cast<std::size_t>(roots) * size * sizeof(double));
  ranks_.all_gather(std::as_bytes(std::span(sent_)), sizes, std::as_writable_bytes(std::span(received_)));
  add_up(partition_->all, received_.data(), size, size);
  std::copy_n(received_.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(partition_->total) * size), size,
              parts);
}

template <class T>
RankRange AllReduce<T>::shard(const Sum& sum, int rank) const {
  return sum.whole ? RankRange{0, sum.values} : rank_range(sum.values, rank, ranks_.size());
}

/// For each rank, the shards of this rank's roots.
template <class T>
void AllReduce<T>::pack(Sum& sum) const {
  std::size_t place = 0;
  for (int to = 0; to < ranks_.size(); ++to) {
    const RankRange range = shard(sum, to);
    for (const int root : partition_->roots) {
      const auto of_root = [&](const Gradient& g) {
        return g.parts + static_cast<std::size_t>(root) * g.gradient.size();
      };
      for_each_piece(sum.gradients, range, of_root, [&](std::size_t first, const T* values, std::size_t count) {
        std::copy_n(values, count, sum.sent.begin() + static_cast<std::ptrdiff_t>(place + first - range.first));
      });
      place += range.count();
    }
  }
}

template <class T>
void AllReduce<T>::start(std::span<const Gradient> gradients) {
  if (begun_ == sums_.size()) sums_.push_back(std::make_unique<Sum>());
  Sum& sum = *sums_[begun_++];
  sum.gradients.assign(gradients.begin(), gradients.end());
  sum.values = 0;
  for (const Gradient& g : gradients) {
    sum.values += g.gradient.size();
    for_each_group(1, static_cast<int>(g.gradient.size()), value_group, [&](int, int first, int last) {
      add_up(partition_->own, g.parts + first, g.gradient.size(), static_cast<std::size_t>(last - first));
    });
  }
  sum.whole = sum.values * sizeof(T) <= small_bytes;

  const auto own_roots = partition_->roots.size();
  const std::size_t own_values = shard(sum, ranks_.rank()).count();
  std::vector<std::size_t> out, in;
  std::size_t sent = 0;
  for (int rank = 0; rank < ranks_.size(); ++rank) {
    out.push_back(own_roots * shard(sum, rank).count());
    sent += out.back();
    in.push_back(static_cast<std::size_t>(partition_->root_counts[static_cast<std::size_t>(rank)]) * own_values);
  }
  sum.sent.resize(sent);
  sum.received.resize(static_cast<std::size_t>(partition_->root_count()) * own_values);
  pack(sum);
  sum.exchange = ranks_.start_exchange(std::as_bytes(std::span(sum.sent)), bytes_of<T>(out),
                                       std::as_writable_bytes(std::span(sum.received)), bytes_of<T>(in));
}

template <class T>
void AllReduce<T>::add_up_shard(Sum& sum) {
  const std::size_t values = shard(sum, ranks_.rank()).count();
  for_each_group(1, static_cast<int>(values), value_group, [&](int, int first, int last) {
    add_up(partition_->all, sum.received.data() + first, values, static_cast<std::size_t>(last - first));
  });
  const auto total =
      sum.received.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(partition_->total) * values);
  sum.own.assign(total, total + static_cast<std::ptrdiff_t>(values));
  if (sum.whole) return unpack(sum, sum.own);
  std::vector<std::size_t> sizes;
  for (int rank = 0; rank < ranks_.size(); ++rank) sizes.push_back(shard(sum, rank).count());
  sum.all.resize(sum.values);
  sum.gather = ranks_.start_all_gather(std::as_bytes(std::span(sum.own)), bytes_of<T>(sizes),
                                       std::as_writable_bytes(std::span(sum.all)));
}

template <class T>
void AllReduce<T>::unpack(const Sum& sum, const std::vector<T>& values) {
  for_each_piece(
      sum.gradients, {0, sum.values}, [](const Gradient& g) { return g.gradient.data(); },
      [&](std::size_t first, T* gradient, std::size_t count) {
        std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(first), count, gradient);
      });
}

template <class T>
void AllReduce<T>::progress() {
  // In the order of the layers at every rank, whichever exchange is done first.
  for (; exchanged_ < begun_ && sums_[exchanged_]->exchange->test(); ++exchanged_) add_up_shard(*sums_[exchanged_]);
  for (std::size_t i = 0; i < exchanged_; ++i)
    if (sums_[i]->gather) sums_[i]->gather->test();
}

template <class T>
void AllReduce<T>::finish() {
  for (; exchanged_ < begun_; ++exchanged_) {
    sums_[exchanged_]->exchange->wait();
    add_up_shard(*sums_[exchanged_]);
  }
  for (std::size_t i = 0; i < begun_; ++i) {
    Sum& sum = *sums_[i];
    if (sum.gather) {
      sum.gather->wait();
      unpack(sum, sum.all);
    }
    sum.exchange.reset();
    sum.gather.reset();
  }
  begun_ = exchanged_ = 0;
}

template class AllReduce<float>;
template class AllReduce<double>;

}  // namespace decid::nn
