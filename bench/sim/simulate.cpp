// Speed of trials, on one thread, for each instruction set, beside the machine's peak of fused multiply-adds in double
// and beside the plain loop.
#include "sim/simulate.hpp"

#include <benchmark/benchmark.h>
#include <omp.h>

#include <algorithm>
#include <span>
#include <vector>

#include "bench/isas.hpp"
#include "bench/sim/plain_trial.hpp"
#include "bench/sim/trials.hpp"
#include "sim/noise.hpp"

namespace {

using namespace decid;
using namespace decid::bench;

/// Trials of the data set's distribution, 160 at once: ten for each lane. The plain loop computes them one after the
/// other, also with noise of its own for each. Only operations of the steps count.
void bench_trials(benchmark::State& state, bool noise, Isa isa) {
  constexpr int count = 160;
  const sim::Simulator simulator(sim::default_protocol(), isa);
  const auto make_trial = [noise](int index) { return bench::make_trial(index, noise); };
  const sim::VestibularNoiseMaker maker(simulator.protocol());
  const auto samples = static_cast<std::size_t>(simulator.samples());
  std::vector<double> noise_rate(samples + 1), sway_rad(samples);
  std::vector<double> plain_times;
  int plain_index = 0;
  const auto run_plain = [&] {
    // A whole trial: those that fall would make it look cheaper.
    for (;; ++plain_index) {
      const sim::TrialInput trial = make_trial(plain_index % count);
      std::fill(noise_rate.begin(), noise_rate.end(), 0.0);
      const double start = cpu_seconds();
      if (noise) maker.velocity(trial.parameters[sim::Nv], trial.noise, noise_rate);
      const double largest = bench::plain_trial(simulator, trial.parameters, noise_rate, sway_rad);
      if (largest > sim::sway_limit_rad) continue;
      plain_times.push_back(cpu_seconds() - start);
      break;
    }
    ++plain_index;
  };
  omp_set_num_threads(1);
  FmaPeak peak(name(isa));
  double simulated_s = 0.0;
  std::vector<double> times;
  const auto run = [&] {
    simulated_s = 0.0;
    const double start = cpu_seconds();
    simulator.run_all(count, make_trial,
                      [&](int, const sim::Outcome& outcome, std::span<double>) { simulated_s += outcome.end_s; });
    times.push_back(cpu_seconds() - start);
  };
  run();
  for (auto _ : state) {
    peak.measure();
    run();
    for (int i = 0; i < 4; ++i) run_plain();
    state.SetIterationTime(times.back());
  }
  const double trial_s = simulator.protocol().duration_s();
  const double whole_trials = simulated_s / trial_s, seconds = best_of(times) / whole_trials;
  state.counters["trials/s"] = 1 / seconds;
  state.counters["us/trial"] = seconds * 1e6;
  state.counters["ns/step"] = seconds / (trial_s * sim::steps_per_second) * 1e9;
  count_double_flops(state, peak, flops_per_step * trial_s * sim::steps_per_second, seconds);
  state.counters["plain us"] = best_of(plain_times) * 1e6;
  state.counters["x plain"] = best_of(plain_times) / seconds;
}

[[maybe_unused]] const bool registered = [] {
  add_for_each_isa("trials", bench_trials, true);
  add_for_each_isa("trials_without_noise", bench_trials, false);
  return true;
}();

}  // namespace
