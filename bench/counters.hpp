// Counters that a benchmark reports beside its time: rates, and their fraction of the machine's peak in the same run.
#pragma once

#include <benchmark/benchmark.h>

#include "bench/machine.hpp"

namespace decid::bench {

/// Counts multiplications and additions; `peak` in GFLOP/s.
inline void count_flops(benchmark::State& state, double peak, double flops, double seconds) {
  state.counters["GFLOP/s"] = flops / seconds * 1e-9;
  state.counters["peak"] = peak;
  state.counters["%peak"] = 100 * flops / seconds * 1e-9 / peak;
}

/// Counts bytes of memory read and written.
inline void count_bytes(benchmark::State& state, const Bandwidth& bandwidth, double bytes, double seconds) {
  state.counters["GB/s"] = bytes / seconds * 1e-9;
  state.counters["bandwidth"] = bandwidth.best();
  state.counters["%bandwidth"] = 100 * bytes / seconds * 1e-9 / bandwidth.best();
}

}  // namespace decid::bench
