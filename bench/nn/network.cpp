// Speed of whole networks: training steps and inference, samples/s, GFLOP/s and % of the multiply-add peak measured
// between the steps. One thread: CPU time; more: wall time, which other programs lengthen. `--layers` prints instead
// where the time of a training step on one thread goes. Pin threads: OMP_PROC_BIND=true OMP_PLACES=cores.
#include <benchmark/benchmark.h>
#include <omp.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <memory>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include "bench/counters.hpp"
#include "bench/nn/networks.hpp"
#include "nn/layers/training_layer.hpp"
#include "nn/predictor.hpp"
#include "nn/training/batch.hpp"

// Counts the allocations of a step: there should be none.
static std::atomic<long> allocations{0};
void* operator new(std::size_t size) {
  ++allocations;
  if (void* p = std::malloc(size > 0 ? size : 1)) return p;
  throw std::bad_alloc();
}
void operator delete(void* p) noexcept {
  std::free(p);
}
void operator delete(void* p, std::size_t) noexcept {
  std::free(p);
}

namespace {

using namespace decid::nn;
using namespace decid::bench;

/// Runs `step` of `flops` operations on `samples` samples until the benchmark has enough.
void measure(benchmark::State& state, int threads, int samples, double flops, const std::function<void()>& step) {
  const auto now = threads == 1 ? cpu_seconds : wall_seconds;
  TeamPeak peak(threads);
  step();  // memory is touched, threads start
  std::vector<double> times;
  times.reserve(1U << 20U);
  long allocated = 0;
  for (auto _ : state) {
    if (times.size() % 16 == 0) peak.measure();
    const long before = allocations;
    const double start = now();
    step();
    const double seconds = now() - start;
    allocated += allocations - before;
    times.push_back(seconds);
    state.SetIterationTime(seconds);
  }
  const double best = best_of(times);
  state.counters["samples/s"] = samples / best;
  state.counters["ms"] = best * 1e3;
  count_flops(state, peak.best(), flops * samples, best);
  state.counters["allocations"] = static_cast<double>(allocated);
}

void bench_training(benchmark::State& state, const NamedNetwork& named, int batch, int threads) {
  omp_set_num_threads(threads);
  Training training(named, batch);
  measure(state, threads, batch, training_flops(training.network), [&] { training.step(); });
  state.counters["MB"] = static_cast<double>(training.trainer.memory_bytes()) * 1e-6;
}

/// Steps on one thread and on two in turns, both by wall time, so that what else the machine does meets both:
/// "speed-up" is the best step of one over the best of two.
void bench_two_threads(benchmark::State& state, const NamedNetwork& named, int batch) {
  constexpr int most = 2;
  std::array<std::unique_ptr<Training>, most> trainings;
  std::array<std::vector<double>, most> times;
  TeamPeak peak(most);
  for (auto _ : state) {
    if (times[0].size() % 16 == 0) peak.measure();
    double sum = 0;
    for (std::size_t i = 0; i < most; ++i) {
      omp_set_num_threads(static_cast<int>(i) + 1);
      if (!trainings[i]) {
        trainings[i] = std::make_unique<Training>(named, batch);
        trainings[i]->step();  // memory is touched, threads start
      }
      const double start = wall_seconds();
      trainings[i]->step();
      times[i].push_back(wall_seconds() - start);
      sum += times[i].back();
    }
    state.SetIterationTime(sum);
  }
  const double one = best_of(times[0]), two = best_of(times[1]);
  state.counters["samples/s"] = batch / two;
  state.counters["speed-up"] = one / two;
  count_flops(state, peak.best(), training_flops(trainings[0]->network) * batch, two);
}

/// The batch's images lie in the executor's layout, as do its outputs; a predictor's batches are of a block for each
/// thread at most.
void bench_inference(benchmark::State& state, const NamedNetwork& named, int batch, int threads) {
  omp_set_num_threads(threads);
  const Network<float> network = initialised(named);
  const Inference<float> inference(network);
  const int at_once = std::min(batch, lanes * threads);
  BatchExecutor<float> executor(inference, at_once);
  load_some(executor.input());
  measure(state, threads, batch, forward_flops(network), [&] {
    for (int done = 0; done < batch; done += at_once) executor.forward();
  });
  state.counters["MB"] = static_cast<double>(inference.bytes() + executor.memory_bytes()) * 1e-6;
}

/// Images to outputs, `batch` in a call; one has channels in the lanes (nn/single.hpp).
void bench_predictor(benchmark::State& state, const NamedNetwork& named, int batch, int threads) {
  omp_set_num_threads(threads);
  const Network<float> network = initialised(named);
  Predictor predictor(network, batch);
  const std::vector<float> images = some_values(static_cast<std::size_t>(batch * named.input.size()));
  std::vector<float> outputs(static_cast<std::size_t>(batch * network.output_shape().size()));
  measure(state, threads, batch, forward_flops(network), [&] { predictor.run(images, outputs); });
  state.counters["MB"] = static_cast<double>(predictor.inference().bytes() + predictor.memory_bytes()) * 1e-6;
}

/// Best times of each layer in training steps, every tensor where a Trainer would have it: a derivative takes the place
/// of the activation if the layer allows it.
class LayerTimes {
 public:
  LayerTimes(const NamedNetwork& named, int batch) : network_(initialised(named)), batch_(batch) {
    OpenSkips<float> none;
    for (Layer<float>& layer : network_.layers())
      layers_.push_back(
          make_training_layer<float>(layer, batch, layers_.empty() ? nullptr : layers_.back().get(), none));
    for (std::size_t i = 0; i <= layers_.size(); ++i) {
      const Shape shape = i > 0 ? layers_[i - 1]->layer().dst_shape() : named.input;
      const Halo halo = i > 0 ? layers_[i - 1]->diff_dst_halo() : Halo{};
      const Halo src_halo = i < layers_.size() ? layers_[i]->src_halo() : Halo{};
      const bool shared =
          i > 0 && i < layers_.size() && layers_[i]->diff_may_replace_src() && !layers_[i - 1]->backward_reads_dst();
      activations_.push_back(tensor(shape, shared ? larger(halo, src_halo) : src_halo));
      differences_.push_back(shared ? activations_.back() : tensor(shape, halo));
    }
    load_some(activations_.front());
    forward_.resize(layers_.size(), std::numeric_limits<double>::max());
    backward_ = forward_;
  }

  void step() {
    const auto keep_best = [](double& best, const std::function<void()>& run) {
      const double start = cpu_seconds();
      run();
      best = std::min(best, cpu_seconds() - start);
    };
    for (std::size_t i = 0; i < layers_.size(); ++i)
      keep_best(forward_[i], [&] { layers_[i]->forward(activations_[i], activations_[i + 1]); });
    load_some(differences_.back());
    for (std::size_t i = layers_.size(); i-- > 0;)
      keep_best(backward_[i], [&] {
        const TensorView<float>* const diff_src = i > 0 ? &differences_[i] : nullptr;
        if (diff_src != nullptr) diff_src->clear_halo();
        layers_[i]->backward(activations_[i], activations_[i + 1], differences_[i + 1], diff_src);
      });
  }

  void print(const char* name, double peak) const {
    double total = 0;
    for (std::size_t i = 0; i < forward_.size(); ++i) total += forward_[i] + backward_[i];
    std::printf("\n%s, batch %d: %.1f ms, %.1f samples/s, %.1f %% of the peak of %.1f GFLOP/s\n", name, batch_,
                total * 1e3, batch_ / total, training_flops(network_) * batch_ / total * 1e-9 / peak * 100, peak);
    std::printf("%-36s %21s %21s %7s\n", "layer", "forward ms  % of peak", "backward ms % of peak", "share");
    for (std::size_t i = 0; i < forward_.size(); ++i) {
      const Layer<float>& layer = layers_[i]->layer();
      std::string text = layer.text();
      for (char& c : text)
        if (c == '\n') c = ' ';
      const double flops = multiplies(layer) ? static_cast<double>(layer.flops()) * batch_ * 1e-9 / peak * 100 : 0;
      std::printf("%-36.36s %11.2f %9s %11.2f %9s %5.1f %%\n", text.c_str(), forward_[i] * 1e3,
                  percent(flops / forward_[i]).c_str(), backward_[i] * 1e3,
                  percent((i > 0 ? 2 : 1) * flops / backward_[i]).c_str(), 100 * (forward_[i] + backward_[i]) / total);
    }
  }

 private:
  static std::string percent(double value) { return value > 0 ? std::to_string(std::lround(value)) : "-"; }
  TensorView<float> tensor(Shape shape, Halo halo) {
    memory_.emplace_back().reserve(TensorView<float>::required(shape, batch_, halo));
    return {memory_.back().data(), shape, batch_, halo};
  }

  Network<float> network_;
  int batch_;
  std::vector<std::unique_ptr<TrainingLayer<float>>> layers_;
  std::vector<AlignedBuffer<float>> memory_;
  std::vector<TensorView<float>> activations_, differences_;
  std::vector<double> forward_, backward_;
};

void print_layers() {
  omp_set_num_threads(1);
  constexpr int steps = 12;
  for (const NamedNetwork& named : named_networks) {
    LayerTimes times(named, 64);
    FmaPeak peak(kernels<float>().name);
    for (int s = 0; s < steps; ++s) {
      times.step();
      peak.measure();
    }
    times.print(named.name, peak.best());
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && std::string_view(argv[1]) == "--layers") {
    print_layers();
    return 0;
  }
  constexpr int inference_batches[] = {1, 16, 64};
  for (const NamedNetwork& named : named_networks)
    for (const int threads : {1, 2}) {
      const auto add = [&](const std::string& what, auto run, auto... arguments) {
        const std::string name = std::string(named.name) + "/" + what + "/threads:" + std::to_string(threads);
        benchmark::RegisterBenchmark(name.c_str(), run, named, arguments..., threads)->UseManualTime();
      };
      add("training/batch:64", bench_training, 64);
      for (const int batch : inference_batches) add("inference/batch:" + std::to_string(batch), bench_inference, batch);
      add("inference/single", bench_predictor, 1);
      add("inference/images:64", bench_predictor, 64);
    }
  for (const NamedNetwork& named : named_networks)
    benchmark::RegisterBenchmark((std::string(named.name) + "/two_threads/batch:64").c_str(), bench_two_threads, named,
                                 64)
        ->UseManualTime();
  benchmark::AddCustomContext("kernels", kernels<float>().name);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
}
