// The processes that share one piece of work, and what they can tell each other. No library is named here: tools/mpi
// makes a communicator of MPI's, tests one of threads. Whoever is given none (a null pointer) works alone.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace decid {

/// Ranks are counted from 0. Calls of one kind are made by all ranks in the same order, by one thread at a time; kinds
/// do not mix, so that an exchange may be under way while others gather. Throws Error for more than 2 GB at once.
class Communicator {
 public:
  virtual ~Communicator() = default;
  virtual int rank() const = 0;
  virtual int size() const = 0;
  bool is_root() const { return rank() == 0; }

  /// Rank 0's bytes, to all.
  virtual void broadcast(std::span<std::byte> bytes) = 0;
  /// Everyone's bytes in order of ranks. sizes: of each rank's; `own` is as long as this rank's, `all` as their sum.
  virtual void all_gather(std::span<const std::byte> own, std::span<const std::size_t> sizes,
                          std::span<std::byte> all) = 0;

  /// Something under way; the memory that it reads and writes must stay.
  class Transfer {
   public:
    virtual ~Transfer() = default;
    /// Moves it on; true: it is done.
    virtual bool test() = 0;
    virtual void wait() = 0;
  };
  /// out: the bytes for rank 0, for rank 1, ...; in: those from rank 0, from rank 1, ...; sizes in bytes.
  virtual std::unique_ptr<Transfer> start_exchange(std::span<const std::byte> out,
                                                   std::span<const std::size_t> out_sizes, std::span<std::byte> in,
                                                   std::span<const std::size_t> in_sizes) = 0;
  /// As all_gather().
  virtual std::unique_ptr<Transfer> start_all_gather(std::span<const std::byte> own, std::span<const std::size_t> sizes,
                                                     std::span<std::byte> all) = 0;

  struct Message {
    int from = 0;
    std::string bytes;
  };
  /// From one rank to another; messages between two arrive in their order.
  virtual void send(int to, const std::string& bytes) = 0;
  /// The next one from anybody; nothing if none has come.
  virtual std::optional<Message> poll() = 0;
};

/// Rank 0's text, at all.
std::string broadcast_text(Communicator& ranks, std::string text);
/// Every rank's text, at all.
std::vector<std::string> gather_texts(Communicator& ranks, const std::string& own);

/// Items that a rank has of `count`, shared evenly and in order: [first, last).
struct RankRange {
  std::size_t first, last;
  std::size_t count() const { return last - first; }
};
inline RankRange range_of(std::size_t count, int rank, int ranks) {
  const auto r = static_cast<std::size_t>(rank), n = static_cast<std::size_t>(ranks);
  return {count * r / n, count * (r + 1) / n};
}

/// `values` has `width` values of type T for each of `count` items, of which each rank has filled its range_of();
/// afterwards all have all.
template <class T>
void gather_ranges(Communicator& ranks, std::size_t count, std::size_t width, std::vector<T>& values) {
  std::vector<std::size_t> sizes;
  for (int r = 0; r < ranks.size(); ++r) sizes.push_back(range_of(count, r, ranks.size()).count() * width * sizeof(T));
  const RankRange own = range_of(count, ranks.rank(), ranks.size());
  const auto begin = values.begin() + static_cast<std::ptrdiff_t>(own.first * width);
  const std::vector<T> sent(begin, begin + static_cast<std::ptrdiff_t>(own.count() * width));
  ranks.all_gather(std::as_bytes(std::span(sent)), sizes, std::as_writable_bytes(std::span(values)));
}

}  // namespace decid
