// Speed of identifying a recording: the library's call behind `decid identify` on one CSV file of 121 s, one thread.
// It reads the file, makes the image, runs the built-in network, re-simulates the result and warns of what is
// unusual; the program's start and its output are not in it. The operations that count are those of the network and of
// the six trials simulated, at the peak of floats.
#include <benchmark/benchmark.h>
#include <omp.h>

#include <vector>

#include "bench/counters.hpp"
#include "bench/dataset/recorded_file.hpp"
#include "bench/nn/networks.hpp"
#include "bench/sim/trials.hpp"
#include "identify/study/study_results.hpp"

namespace {

using namespace decid;

void identify_file(benchmark::State& state) {
  constexpr int simulated_trials = 33;
  omp_set_num_threads(1);
  const bench::RecordedFile file;
  const Model model = built_in_model();
  bench::FmaPeak peak(name(chosen_isa()));
  std::vector<double> times;
  for (auto _ : state) {
    peak.measure();
    const double start = bench::cpu_seconds();
    benchmark::DoNotOptimize(identify_plan(model, "the model", make_plan({file.path()}, {})));
    times.push_back(bench::cpu_seconds() - start);
    state.SetIterationTime(times.back());
  }
  const double seconds = bench::best_of(times);
  state.counters["ms"] = seconds * 1e3;
  bench::count_flops(state, peak.best(),
                     bench::forward_flops(model.network) +
                         simulated_trials * bench::flops_per_step * model.protocol.experiment.steps(),
                     seconds);
}
BENCHMARK(identify_file)->Name("identify/file/threads:1")->UseManualTime();

}  // namespace

BENCHMARK_MAIN();
