// Time and memory as the work grows: data sets against their trials, training steps against the batch, convolutions
// against their channels, each also by threads. tools/bench --scaling runs each point in its own process, because MB is
// the process's peak memory above its memory at the start.
#include <benchmark/benchmark.h>
#include <omp.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bench/dataset/recorded_file.hpp"
#include "bench/nn/convolutions.hpp"
#include "bench/nn/networks.hpp"
#include "dataset/npz/npz.hpp"

namespace {

using namespace decid;

/// A figure of /proc/self/status, which is in kB.
double status_megabytes(const std::string& key) {
  std::ifstream file("/proc/self/status");
  for (std::string word; file >> word;) {
    double kilobytes = 0;
    if (word == key + ":" && file >> kilobytes) return kilobytes * 1.024e-3;
  }
  throw Error(Code::not_supported, "/proc/self/status", "has no " + key, "memory is measured on Linux only");
}

/// The peak of memory beyond `before`. The kernel's own count (getrusage) would begin with the peak of the process that
/// started this program; writing 5 resets it (man 5 proc).
class PeakMemory {
 public:
  PeakMemory() {
    std::ofstream("/proc/self/clear_refs") << 5 << std::flush;
    before_ = status_megabytes("VmRSS");
  }
  double megabytes() const { return status_megabytes("VmHWM") - before_; }

 private:
  double before_;
};

/// One thread: CPU time; more: wall time. `prepare` makes what is run, and its memory counts.
void measure(benchmark::State& state, int threads, const std::function<std::function<void()>()>& prepare) {
  omp_set_num_threads(threads);
#pragma omp parallel
  {}
  const auto now = threads == 1 ? bench::cpu_seconds : bench::wall_seconds;
  static const PeakMemory peak;  // from before the first of the calls that find out how often to repeat
  const auto run = prepare();
  std::vector<double> times;
  for (auto _ : state) {
    const double start = now();
    run();
    times.push_back(now() - start);
    state.SetIterationTime(times.back());
  }
  state.counters["best s"] = bench::best_of(times);
  state.counters["MB"] = peak.megabytes();
}

/// Written to a file, as `decid dataset` does; without children.
void dataset_trials(benchmark::State& state, int trials, int threads) {
  measure(state, threads, [trials]() -> std::function<void()> {
    const auto folder = std::make_shared<bench::ScratchFolder>();
    dataset::DatasetRequest request;
    request.count = request.base = trials;
    request.seed = 1;
    request.protocol = sim::default_protocol();
    return [folder, request] { dataset::generate_npz(folder->path() / "data.npz", request, "scaling"); };
  });
}

void training_batch(benchmark::State& state, int batch, int threads) {
  measure(state, threads, [batch]() -> std::function<void()> {
    const auto training = std::make_shared<bench::Training>(bench::best_network, batch);
    return [training] { training->step(); };
  });
}

/// As many channels in as out, forward, 32 samples.
void convolution_channels(benchmark::State& state, int channels, int) {
  measure(state, 1, [channels]() -> std::function<void()> {
    const auto conv = std::make_shared<bench::ConvRun>(bench::same("", channels, channels, 27, 3, 1).shape);
    return [conv] { conv->run_batch(nn::kernels<float>(), bench::Direction::forward); };
  });
}

}  // namespace

int main(int argc, char** argv) {
  const auto add = [](const std::string& what, auto run, std::vector<int> sizes, std::vector<int> threads) {
    for (const int t : threads)
      for (const int size : sizes)
        benchmark::RegisterBenchmark((what + ":" + std::to_string(size) + "/threads:" + std::to_string(t)).c_str(), run,
                                     size, t)
            ->UseManualTime();
  };
  add("dataset/trials", dataset_trials, {1024, 4096, 16384}, {1, 2});
  add("training/batch", training_batch, {32, 64, 128, 256, 512}, {1, 2});
  add("convolution/channels", convolution_channels, {16, 32, 64, 128, 256}, {1});
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
}
