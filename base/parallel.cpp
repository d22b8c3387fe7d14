// A team of threads for many short loops, see parallel.hpp. The caller opens a loop and works on it; the others join if
// they come in time, and the caller waits only for those that joined. So a thread that the system keeps from running
// costs nothing but its help. Each thread begins with its own part of the items, the same in every loop, so that it
// finds in its cache what it wrote in the loop before; then it helps with the others' parts. A page (WebAssembly) has
// one thread.
#include "base/parallel.hpp"

#ifndef __wasm__
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#endif

namespace decid::detail {

#ifdef __wasm__
bool run_in_team(int, const void*, CallItem) {
  return false;
}
void run_with_team(const void* body, void (*call)(const void* body)) {
  call(body);
}
#else
namespace {

/// The time that a thread spins before it sleeps: longer than the gaps between the loops of a training step, shorter
/// than a time slice.
constexpr std::chrono::microseconds spin_time{150};

void pause() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

/// Returns true if done() became true while spinning.
template <class Done>
bool spin(const Done& done) {
  const auto end = std::chrono::steady_clock::now() + spin_time;
  do {
    for (int i = 0; i < 64; ++i) {
      if (done()) return true;
      pause();
    }
  } while (std::chrono::steady_clock::now() < end);
  return false;
}

class Team {
 public:
  explicit Team(int threads) : used_(std::min(threads, max_parts)) {}

  void run(int count, const void* body, CallItem call) {
    body_ = body;
    call_ = call;
    for (int p = 0; p < used_; ++p) {
      Part& part = parts_[static_cast<std::size_t>(p)];
      part.next.store(bound(count, p), std::memory_order_relaxed);
      part.end = bound(count, p + 1);
    }
    const std::uint32_t round = (state_.load(std::memory_order_relaxed) & ~(open | members)) + one_round;
    state_.store(round | open, std::memory_order_release);
    state_.notify_all();
    take_items(0);
    close();
  }
  /// Makes the threads leave help().
  void end() {
    state_.store(ended, std::memory_order_release);
    state_.notify_all();
  }
  /// Takes part in loops until the end.
  void help(int thread) {
    for (std::uint32_t seen = 0;;) {
      std::uint32_t state = state_.load(std::memory_order_acquire);
      const auto has_news = [&] {
        state = state_.load(std::memory_order_acquire);
        return state == ended || ((state & open) != 0 && state / one_round != seen);
      };
      if (!has_news() && !spin(has_news)) {
        state_.wait(state, std::memory_order_acquire);
        continue;
      }
      if (state == ended) return;
      if (!state_.compare_exchange_strong(state, state + 1, std::memory_order_acquire)) continue;
      seen = state / one_round;
      take_items(thread);
      if ((state_.fetch_sub(1, std::memory_order_acq_rel) & (open | members)) == 1) {
        left_.fetch_add(1, std::memory_order_release);
        left_.notify_one();
      }
    }
  }

 private:
  // The state: how many threads have joined the loop, whether more may, and the number of the loop.
  static constexpr std::uint32_t members = (1U << 12U) - 1, open = 1U << 12U, one_round = 1U << 13U, ended = ~0U;

  /// Items of the open loop that a thread begins with.
  struct alignas(64) Part {
    std::atomic<int> next{0};
    int end = 0;
  };
  static constexpr int max_parts = 64;

  int bound(int count, int part) const { return static_cast<int>(static_cast<long long>(count) * part / used_); }
  void take_items(int thread) {
    for (int k = 0; k < used_; ++k) {
      Part& part = parts_[static_cast<std::size_t>((thread + k) % used_)];
      for (int i = part.next.fetch_add(1, std::memory_order_relaxed); i < part.end;
           i = part.next.fetch_add(1, std::memory_order_relaxed))
        call_(body_, i);
    }
  }
  void close() {
    state_.fetch_and(~open, std::memory_order_acq_rel);
    const auto is_empty = [this] { return (state_.load(std::memory_order_acquire) & members) == 0; };
    while (!spin(is_empty)) {
      const std::uint32_t left = left_.load(std::memory_order_acquire);
      if (is_empty()) return;
      left_.wait(left, std::memory_order_acquire);
    }
  }

  alignas(64) std::atomic<std::uint32_t> state_{0};
  alignas(64) std::atomic<std::uint32_t> left_{0};  // counts threads that left last, after the loop was closed
  std::array<Part, max_parts> parts_;
  int used_;                    // of them
  const void* body_ = nullptr;  // of the open loop
  CallItem call_ = nullptr;
};

thread_local Team* own_team = nullptr;

}  // namespace

bool run_in_team(int count, const void* body, CallItem call) {
  Team* const team = own_team;
  if (team == nullptr) return false;
  own_team = nullptr;  // for loops within the loop
  team->run(count, body, call);
  own_team = team;
  return true;
}

void run_with_team(const void* body, void (*call)(const void* body)) {
  if (thread_count() < 2 || own_team != nullptr || omp_in_parallel() != 0) return call(body);
  const int threads = thread_count();
  Team team(threads);
  std::exception_ptr failure;
#pragma omp parallel num_threads(threads)
  {
    if (omp_get_thread_num() == 0) {
      own_team = &team;
      try {
        call(body);
      } catch (...) {
        failure = std::current_exception();
      }
      own_team = nullptr;
      team.end();
    } else {
      team.help(omp_get_thread_num());
    }
  }
  if (failure) std::rethrow_exception(failure);
}
#endif

}  // namespace decid::detail
