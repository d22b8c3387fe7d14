// Parallel loops whose results do not depend on the number of threads: each index is computed separately, and nothing
// is reduced here.
#pragma once

#include <omp.h>

#include <atomic>
#include <exception>

namespace decid {

/// Returns the number of threads of parallel_for: OMP_NUM_THREADS, or the value of omp_set_num_threads.
inline int thread_count() {
  return omp_get_max_threads();
}

/// Calls body(i) for i in [0, count) on OpenMP's threads. Rethrows the first exception in the caller.
template <class Body>
void parallel_for(int count, const Body& body) {
  std::exception_ptr failure;
  std::atomic<bool> failed{false};
#pragma omp parallel for schedule(dynamic, 1) if (count > 1)
  for (int i = 0; i < count; ++i) {
    if (failed.load(std::memory_order_relaxed)) continue;
    try {
      body(i);
    } catch (...) {
      if (!failed.exchange(true)) failure = std::current_exception();
    }
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace decid
