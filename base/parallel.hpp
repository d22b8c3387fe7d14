// Parallel loops whose results do not depend on the number of threads: each index is computed separately, and nothing
// is reduced here.
//
// A child after fork() has none of its parent's OpenMP threads, but the runtime still counts on them, so a loop of
// several threads waits forever. A child may use these functions only if its parent has had one thread so far
// (OMP_NUM_THREADS=1, or omp_set_num_threads(1) before the first loop of each thread). Otherwise start a new program.
#pragma once

#include <omp.h>

#include <algorithm>
#include <atomic>
#include <exception>

namespace decid {

/// The number of threads at most: OpenMP's runtime ends the process where the system has none left.
inline constexpr int max_threads = 1024;

/// Returns the number of threads of parallel_for: OMP_NUM_THREADS, or the value of omp_set_num_threads, but at most
/// max_threads.
inline int thread_count() {
  return std::min(omp_get_max_threads(), max_threads);
}

namespace detail {
using CallItem = void (*)(const void* body, int item);
/// Calls call(body, i) for i in [0, count) on the threads of the caller's with_team(). Returns false if the caller is
/// not in one, or already in such a loop.
bool run_in_team(int count, const void* body, CallItem call);
/// Calls body() with a team, see with_team().
void run_with_team(const void* body, void (*call)(const void* body));
}  // namespace detail

/// Calls body(i) for i in [0, count) on OpenMP's threads. Rethrows the first exception in the caller.
template <class Body>
void parallel_for(int count, const Body& body) {
  std::exception_ptr failure;
  std::atomic<bool> failed{false};
  const auto guarded = [&](int i) {
    if (failed.load(std::memory_order_relaxed)) return;
    try {
      body(i);
    } catch (...) {
      if (!failed.exchange(true)) failure = std::current_exception();
    }
  };
  const auto call = [](const void* item_body, int i) { (*static_cast<const decltype(guarded)*>(item_body))(i); };
  if (count < 2 || !detail::run_in_team(count, &guarded, call)) {
#pragma omp parallel for schedule(dynamic, 1) num_threads(thread_count()) if (count > 1)
    for (int i = 0; i < count; ++i) guarded(i);
  }
  if (failure) std::rethrow_exception(failure);
}

/// Calls body() once in each of OpenMP's threads. Rethrows the first exception in the caller.
template <class Body>
void in_each_thread(const Body& body) {
  std::exception_ptr failure;
  std::atomic<bool> failed{false};
#pragma omp parallel num_threads(thread_count())
  {
    try {
      body();
    } catch (...) {
      if (!failed.exchange(true)) failure = std::current_exception();
    }
  }
  if (failure) std::rethrow_exception(failure);
}

/// Calls body() and keeps OpenMP's threads at hand for its parallel_for calls. For many loops of less than a
/// millisecond: OpenMP would wake the threads for each of them, or let them spin and wait for each other when others
/// use the processors. Only what body() itself calls may be parallel. Exceptions pass.
template <class Body>
void with_team(const Body& body) {
  detail::run_with_team(&body, [](const void* own) { (*static_cast<const Body*>(own))(); });
}

}  // namespace decid
