// A team of threads for many short loops, see parallel.hpp. The caller opens a loop and works on it; the others join if
// they come in time, and the caller waits only for those that joined. So a thread that the system keeps from running
// costs nothing but its help. A page (WebAssembly) has one thread.
#include "base/parallel.hpp"

#ifndef __wasm__
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
constexpr std::chrono::microseconds spin_time{50};

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
  void run(int count, const void* body, CallItem call) {
    count_ = count;
    body_ = body;
    call_ = call;
    next_.store(0, std::memory_order_relaxed);
    const std::uint32_t round = (state_.load(std::memory_order_relaxed) & ~(open | members)) + one_round;
    state_.store(round | open, std::memory_order_release);
    state_.notify_all();
    take_items();
    close();
  }
  /// Makes the threads leave help().
  void end() {
    state_.store(ended, std::memory_order_release);
    state_.notify_all();
  }
  /// Takes part in loops until the end.
  void help() {
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
      take_items();
      if ((state_.fetch_sub(1, std::memory_order_acq_rel) & (open | members)) == 1) {
        left_.fetch_add(1, std::memory_order_release);
        left_.notify_one();
      }
    }
  }

 private:
  // The state: how many threads have joined the loop, whether more may, and the number of the loop.
  static constexpr std::uint32_t members = (1U << 12U) - 1, open = 1U << 12U, one_round = 1U << 13U, ended = ~0U;

  void take_items() {
    for (int i = next_.fetch_add(1, std::memory_order_relaxed); i < count_;
         i = next_.fetch_add(1, std::memory_order_relaxed))
      call_(body_, i);
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
  alignas(64) std::atomic<int> next_{0};
  alignas(64) std::atomic<std::uint32_t> left_{0};  // counts threads that left last, after the loop was closed
  int count_ = 0;                                   // these are of the open loop
  const void* body_ = nullptr;
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
  Team team;
  std::exception_ptr failure;
#pragma omp parallel
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
      team.help();
    }
  }
  if (failure) std::rethrow_exception(failure);
}
#endif

}  // namespace decid::detail
