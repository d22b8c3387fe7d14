// Ranks that are threads of one process: a communicator whose transfers are done as soon as all ranks have begun them.
#pragma once

#include <algorithm>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "base/communicator.hpp"

namespace decid::test {

/// State shared by the ranks: the bytes of each rank in every call, and messages on their way.
struct ThreadHub {
  struct Given {
    std::vector<std::byte> bytes;
    std::vector<std::size_t> sizes;  // for each rank
  };
  using Call = std::pair<int, int>;  // kind, how many of it came before
  explicit ThreadHub(int count) : ranks(count), messages(static_cast<std::size_t>(count)) {}

  const int ranks;
  std::mutex mutex;
  std::condition_variable changed;
  std::map<Call, std::map<int, Given>> given;
  std::vector<std::deque<Communicator::Message>> messages;
};

class ThreadRanks final : public Communicator {
 public:
  ThreadRanks(ThreadHub& hub, int rank) : hub_(hub), rank_(rank) {}
  int rank() const override { return rank_; }
  int size() const override { return hub_.ranks; }

  void broadcast(std::span<std::byte> bytes) override {
    const std::vector<std::size_t> everybody(static_cast<std::size_t>(size()), bytes.size());
    std::vector<std::size_t> from_root(everybody.size(), 0);
    from_root[0] = bytes.size();
    if (!is_root()) return begin(0, {}, std::vector<std::size_t>(everybody.size(), 0), bytes, from_root)->wait();
    std::vector<std::byte> copies;
    for (std::size_t r = 0; r < everybody.size(); ++r) copies.insert(copies.end(), bytes.begin(), bytes.end());
    begin(0, copies, everybody, bytes, from_root)->wait();
  }
  void all_gather(std::span<const std::byte> own, std::span<const std::size_t> sizes,
                  std::span<std::byte> all) override {
    gather(1, own, sizes, all)->wait();
  }
  std::unique_ptr<Transfer> start_exchange(std::span<const std::byte> out, std::span<const std::size_t> out_sizes,
                                           std::span<std::byte> in, std::span<const std::size_t> in_sizes) override {
    return begin(2, out, out_sizes, in, in_sizes);
  }
  std::unique_ptr<Transfer> start_all_gather(std::span<const std::byte> own, std::span<const std::size_t> sizes,
                                             std::span<std::byte> all) override {
    return gather(3, own, sizes, all);
  }

  void send(int to, const std::string& bytes) override {
    const std::scoped_lock lock(hub_.mutex);
    hub_.messages[static_cast<std::size_t>(to)].push_back({rank_, bytes});
  }
  std::optional<Message> poll() override {
    const std::scoped_lock lock(hub_.mutex);
    auto& mine = hub_.messages[static_cast<std::size_t>(rank_)];
    if (mine.empty()) return std::nullopt;
    Message first = std::move(mine.front());
    mine.pop_front();
    return first;
  }

 private:
  class Pending final : public Transfer {
   public:
    Pending(ThreadHub& hub, int rank, ThreadHub::Call call, std::span<std::byte> in, std::span<const std::size_t> sizes)
        : hub_(hub), rank_(rank), call_(call), in_(in), sizes_(sizes.begin(), sizes.end()) {}
    bool test() override {
      const std::scoped_lock lock(hub_.mutex);
      return take();
    }
    void wait() override {
      std::unique_lock lock(hub_.mutex);
      hub_.changed.wait(lock, [&] { return take(); });
    }

   private:
    bool take() {
      const auto& given = hub_.given[call_];
      if (done_ || static_cast<int>(given.size()) < hub_.ranks) return done_;
      std::size_t to = 0, from_rank = 0;
      for (const auto& [rank, its] : given) {
        std::size_t from = 0;
        for (int r = 0; r < rank_; ++r) from += its.sizes[static_cast<std::size_t>(r)];
        const std::size_t size = its.sizes[static_cast<std::size_t>(rank_)];
        // Sent and expected sizes must agree, as for every communicator.
        if (size != sizes_[from_rank++] || from + size > its.bytes.size() || to + size > in_.size()) std::abort();
        if (size > 0) std::memcpy(in_.data() + to, its.bytes.data() + from, size);
        to += size;
      }
      return done_ = true;
    }

    ThreadHub& hub_;
    int rank_;
    ThreadHub::Call call_;
    std::span<std::byte> in_;
    std::vector<std::size_t> sizes_;
    bool done_ = false;
  };

  std::unique_ptr<Transfer> begin(int kind, std::span<const std::byte> out, std::span<const std::size_t> out_sizes,
                                  std::span<std::byte> in, std::span<const std::size_t> in_sizes) {
    const ThreadHub::Call call{kind, calls_[kind]++};
    auto pending = std::make_unique<Pending>(hub_, rank_, call, in, in_sizes);
    {
      const std::scoped_lock lock(hub_.mutex);
      hub_.given[call][rank_] = {{out.begin(), out.end()}, {out_sizes.begin(), out_sizes.end()}};
    }
    hub_.changed.notify_all();
    return pending;
  }
  std::unique_ptr<Transfer> gather(int kind, std::span<const std::byte> own, std::span<const std::size_t> sizes,
                                   std::span<std::byte> all) {
    std::vector<std::byte> copies;
    for (int r = 0; r < size(); ++r) copies.insert(copies.end(), own.begin(), own.end());
    return begin(kind, copies, std::vector<std::size_t>(static_cast<std::size_t>(size()), own.size()), all, sizes);
  }

  ThreadHub& hub_;
  int rank_;
  std::map<int, int> calls_;
};

/// Calls body for all ranks at the same time.
inline void with_ranks(int ranks, const std::function<void(Communicator&)>& body) {
  ThreadHub hub(ranks);
  std::vector<std::thread> threads;
  for (int rank = 0; rank < ranks; ++rank)
    threads.emplace_back([&hub, &body, rank] {
      ThreadRanks own(hub, rank);
      body(own);
    });
  for (std::thread& thread : threads) thread.join();
}

}  // namespace decid::test
