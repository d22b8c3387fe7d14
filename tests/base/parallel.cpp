// Tests of base/parallel.hpp: every index once, with and without a team, and exceptions reach the caller.
#include "base/parallel.hpp"

#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

using namespace decid;

namespace {

/// Restores the number of threads.
struct Threads {
  explicit Threads(int count) { omp_set_num_threads(count); }
  ~Threads() { omp_set_num_threads(before); }
  int before = omp_get_max_threads();
};

/// Calls a loop of each length up to `longest` in turn and returns the number of indices that did not run once.
int wrong_indices(int loops, int longest) {
  int wrong = 0;
  for (int k = 0; k < loops; ++k) {
    const int count = k % (longest + 1);
    std::vector<int> runs(static_cast<std::size_t>(count));
    parallel_for(count, [&](int i) { ++runs[static_cast<std::size_t>(i)]; });
    for (const int run : runs) wrong += run != 1;
  }
  return wrong;
}

}  // namespace

TEST_CASE("parallel_for: each index once, for any number of threads, with a team and without") {
  for (const int threads : {1, 2, 3, 8}) {
    const Threads set(threads);
    CHECK(wrong_indices(50, 20) == 0);
    int wrong = -1;
    with_team([&] { wrong = wrong_indices(3000, 20); });
    CHECK(wrong == 0);
  }
}

TEST_CASE("thread_count: at most max_threads, whatever OMP_NUM_THREADS is") {
  const Threads set(100000);
  CHECK(thread_count() == max_threads);
}

TEST_CASE("in_each_thread: once in each thread, and exceptions reach the caller") {
  for (const int threads : {1, 3}) {
    const Threads set(threads);
    std::atomic<int> calls{0};
    in_each_thread([&] { ++calls; });
    CHECK(calls == threads);
    CHECK_THROWS_AS(in_each_thread([] { throw std::length_error("body"); }), std::length_error);
  }
}

TEST_CASE("with_team: threads that sleep between loops join again, loops within loops run") {
  const Threads set(2);
  std::atomic<int> sum{0};
  std::vector<std::thread::id> thread_of(2);
  with_team([&] {
    for (int k = 0; k < 3; ++k) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      std::atomic<int> begun{0};
      parallel_for(2, [&](int i) {
        // Both items run at the same time, so on two threads.
        ++begun;
        while (begun.load() < 2) std::this_thread::yield();
        thread_of[static_cast<std::size_t>(i)] = std::this_thread::get_id();
        parallel_for(5, [&](int own) { sum += own; });
        with_team([&] { parallel_for(5, [&](int own) { sum += own; }); });
      });
      CHECK(thread_of[0] != thread_of[1]);
    }
    with_team([&] { parallel_for(5, [&](int own) { sum += own; }); });
  });
  CHECK(sum == 3 * 2 * 20 + 10);
}

TEST_CASE("parallel_for and with_team: exceptions reach the caller, and the next loop runs") {
  for (const int threads : {1, 4}) {
    const Threads set(threads);
    const auto failing = [] {
      parallel_for(9, [](int i) {
        if (i == 7) throw std::out_of_range("item");
      });
    };
    CHECK_THROWS_AS(failing(), std::out_of_range);
    with_team([&] {
      CHECK_THROWS_AS(failing(), std::out_of_range);
      CHECK(wrong_indices(30, 20) == 0);
    });
    CHECK_THROWS_AS(with_team([&] { failing(); }), std::out_of_range);
    CHECK_THROWS_AS(with_team([] { throw std::length_error("body"); }), std::length_error);
    CHECK(wrong_indices(30, 20) == 0);
  }
}
