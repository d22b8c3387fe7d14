// Communication between the processes that share one task. This header names no library: tools/mpi implements it with
// MPI, tests with threads. A null pointer means a single process.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace decid {

/// Ranks count from 0. All ranks make the calls of one kind in the same order, from one thread at a time. Kinds are
/// independent, so an exchange may run while others gather. Throws Error for more than 2 GB at once.
class Communicator {
 public:
  virtual ~Communicator() = default;
  virtual int rank() const = 0;
  virtual int size() const = 0;
  bool is_root() const { return rank() == 0; }

  /// Sends rank 0's bytes to all.
  virtual void broadcast(std::span<std::byte> bytes) = 0;
  /// Sends each rank's bytes to all, in order of ranks. sizes: per rank; `own` has this rank's size, `all` their sum.
  virtual void all_gather(std::span<const std::byte> own, std::span<const std::size_t> sizes,
                          std::span<std::byte> all) = 0;

  /// A running transfer; the memory that it reads and writes must stay valid.
  class Transfer {
   public:
    virtual ~Transfer() = default;
    /// Advances the transfer; returns true when it is complete.
    virtual bool test() = 0;
    virtual void wait() = 0;
  };
  /// Starts an exchange. out: the bytes for rank 0, for rank 1, ...; in: those from rank 0, from rank 1, ...; sizes in
  /// bytes.
  virtual std::unique_ptr<Transfer> start_exchange(std::span<const std::byte> out,
                                                   std::span<const std::size_t> out_sizes, std::span<std::byte> in,
                                                   std::span<const std::size_t> in_sizes) = 0;
  /// Starts what all_gather() does.
  virtual std::unique_ptr<Transfer> start_all_gather(std::span<const std::byte> own, std::span<const std::size_t> sizes,
                                                     std::span<std::byte> all) = 0;

  struct Message {
    int from = 0;
    std::string bytes;
  };
  /// Sends from one rank to another; messages between two ranks arrive in order.
  virtual void send(int to, const std::string& bytes) = 0;
  /// Returns the next message from any rank; nothing if none has arrived.
  virtual std::optional<Message> poll() = 0;
};

/// Returns rank 0's text at all ranks. ranks: null for a single process, here and below.
std::string broadcast_text(Communicator* ranks, std::string text);
/// Returns every rank's text at all ranks.
std::vector<std::string> gather_texts(Communicator* ranks, const std::string& own);

/// A rank's part of `count` items, partitioned evenly and in order: [first, last).
struct RankRange {
  std::size_t first, last;
  std::size_t count() const { return last - first; }
};
inline RankRange rank_range(std::size_t count, int rank, int ranks) {
  const auto r = static_cast<std::size_t>(rank), n = static_cast<std::size_t>(ranks);
  return {count * r / n, count * (r + 1) / n};
}

/// Completes `values`, `width` values of type T for each of `count` items, of which each rank has filled its
/// rank_range(). Afterwards all ranks have all values.
template <class T>
void gather_ranges(Communicator& ranks, std::size_t count, std::size_t width, std::vector<T>& values) {
  std::vector<std::size_t> sizes;
  for (int r = 0; r < ranks.size(); ++r)
    sizes.push_back(rank_range(count, r, ranks.size()).count() * width * sizeof(T));
  const RankRange own = rank_range(count, ranks.rank(), ranks.size());
  const auto begin = values.begin() + static_cast<std::ptrdiff_t>(own.first * width);
  const std::vector<T> sent(begin, begin + static_cast<std::ptrdiff_t>(own.count() * width));
  ranks.all_gather(std::as_bytes(std::span(sent)), sizes, std::as_writable_bytes(std::span(values)));
}

}  // namespace decid
