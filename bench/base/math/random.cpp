// Speed of normal deviates, on one thread, for each instruction set, beside the machine's bandwidth of memory.
#include "base/math/random.hpp"

#include <benchmark/benchmark.h>

#include <vector>

#include "bench/isas.hpp"

namespace {

using namespace decid;
using namespace decid::bench;

/// The sensor's noise of a trial, beside what memory could take of it.
void bench_normals(benchmark::State& state, Isa isa) {
  std::vector<double> values(12100);
  Bandwidth bandwidth;
  const double seconds = best_seconds(state, bandwidth, [&] { Random(1, Stream{5}, 0).fill_normal(values, 1, isa); });
  state.counters["us/trial"] = seconds * 1e6;
  state.counters["ns/number"] = seconds / static_cast<double>(values.size()) * 1e9;
  count_bytes(state, bandwidth, 8.0 * static_cast<double>(values.size()), seconds);
}

[[maybe_unused]] const bool registered = [] {
  add_for_each_isa("sensor_noise", bench_normals);
  return true;
}();

}  // namespace
