// Benchmarks of one function for each instruction set, beside what the machine gives in the same run.
#pragma once

#include <benchmark/benchmark.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "base/isa.hpp"
#include "bench/counters.hpp"

namespace decid::bench {

/// Registers "<isa>/<what>" for each instruction set of this processor; `run` takes the state, `arguments` and it.
template <class Run, class... Arguments>
void add_for_each_isa(const std::string& what, Run run, Arguments... arguments) {
  for (const Isa isa : available_isas())
    benchmark::RegisterBenchmark((name(isa) + ("/" + what)).c_str(), run, arguments..., isa)->UseManualTime();
}

/// Seconds of the best run; the machine is measured now and then in between.
template <class Machine>
double best_seconds(benchmark::State& state, Machine& machine, const std::function<void()>& run) {
  constexpr std::size_t machine_every = 64;
  std::vector<double> times;
  run();
  for (auto _ : state) {
    if (times.size() % machine_every == 0) machine.measure();
    const double start = cpu_seconds();
    run();
    times.push_back(cpu_seconds() - start);
    state.SetIterationTime(times.back());
  }
  return best_of(times);
}

/// Operations of a real FFT as FFTW counts them.
inline double fft_flops(double length) {
  return 2.5 * length * std::log2(length);
}

/// Counts operations in double: a register holds half as many doubles as floats, which the peak counts.
inline void count_double_flops(benchmark::State& state, const FmaPeak& peak, double flops, double seconds) {
  count_flops(state, peak.best() / 2, flops, seconds);
}

}  // namespace decid::bench
