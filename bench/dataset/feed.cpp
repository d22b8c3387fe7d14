// Cost of streamed trials in a training. One run alternates steps on batches in memory, simulation of as many trials
// and network inputs, and steps fed by dataset/feed.hpp. Wall time, as network and feed share the cores and have equal
// numbers of threads. "cost %" is the time that streaming adds to a step. "overlap" is the time of both apart over the
// time of both together; 1 is the best on busy cores. Operations are the network's.
#include "dataset/feed.hpp"

#include <benchmark/benchmark.h>
#include <omp.h>

#include <functional>
#include <numeric>
#include <string>
#include <vector>

#include "bench/counters.hpp"
#include "bench/nn/networks.hpp"
#include "identify/training/presets.hpp"

namespace {

using namespace decid;

double seconds_of(const std::function<void()>& run) {
  const double start = bench::wall_seconds();
  run();
  return bench::wall_seconds() - start;
}

void bench_stream(benchmark::State& state, const bench::NamedNetwork& named, const dataset::ImageSettings& image,
                  sim::SensorNoise noise, int threads) {
  constexpr int batch = 64, steps_a_block = 8, steps = 6 * steps_a_block;
  omp_set_num_threads(threads);
  sim::Protocol protocol = sim::default_protocol();
  protocol.noise.sensor = noise;
  const auto source = dataset::stream_source(protocol, 1, 1 << 20, 1);
  const dataset::ImageMaker images(image, protocol.samples());
  const dataset::Scaling scaling = dataset::measure_scaling(*source, images, 256);
  const dataset::Encoding encoding{images, scaling.rows};
  bench::Training training(named, batch);
  const auto values = static_cast<std::size_t>(named.input.size());

  std::vector<int> indices(batch * steps);
  std::iota(indices.begin(), indices.end(), 0);
  std::vector<float> made(indices.size() * values);
  const auto make = [&] {
    dataset::encode_all(
        encoding,
        [&](const dataset::SwaySink& take) {
          source->take(
              dataset::Part::training, 0, indices,
              [&](std::size_t place, const sim::Parameters&, const dataset::Sway& sway) { take(place, sway); });
        },
        made);
  };
  const auto load = [&](std::span<const float> from) {
    for (int i = 0; i < batch; ++i)
      training.trainer.input().load(i, from.subspan(static_cast<std::size_t>(i) * values, values));
  };
  const auto step = [&] {
    for (int i = 0; i < steps; ++i) {
      load(std::span(made).subspan(static_cast<std::size_t>(i) * batch * values));
      training.step();
    }
  };
  /// Two blocks to begin with: the feed is a block ahead, at the start of what is timed as at its end.
  const auto fed_seconds = [&] {
    dataset::Feed feed(*source, encoding, scaling.targets, batch, 1, 0, 1);
    const auto fed_steps = [&](int count) {
      for (int i = 0; i < count; ++i) {
        load(feed.next().images);
        training.step();
      }
    };
    fed_steps(2 * steps_a_block);
    return seconds_of([&] { fed_steps(steps); });
  };
  make();
  step();
  std::vector<double> alone, making, fed;
  bench::TeamPeak peak(threads);
  for (auto _ : state) {
    peak.measure();
    alone.push_back(seconds_of(step));
    making.push_back(seconds_of(make));
    fed.push_back(fed_seconds());
    state.SetIterationTime(fed.back());
  }
  const double per_us = 1e6 / (batch * steps);
  const double step_us = bench::best_of(alone) * per_us, make_us = bench::best_of(making) * per_us,
               fed_us = bench::best_of(fed) * per_us;
  state.counters["step us"] = step_us;
  state.counters["trial us"] = make_us;
  state.counters["fed us"] = fed_us;
  state.counters["samples/s"] = 1e6 / fed_us;
  state.counters["cost %"] = 100 * (fed_us / step_us - 1);
  state.counters["overlap"] = (step_us + make_us) / fed_us;
  bench::count_flops(state, peak.best(), bench::training_flops(training.network), fed_us * 1e-6);
}

}  // namespace

int main(int argc, char** argv) {
  for (const bench::NamedNetwork& named : bench::named_networks) {
    const std::string name = named.name;
    // A step of NetB takes so long that trials do not count; the others have inputs of their own.
    if (name != "NetA" && name != "Best") continue;
    const Preset preset = preset_named(name == "Best" ? "best" : "paper");
    for (const bool noisy : {false, true}) {
      for (const int threads : {1, 2}) {
        benchmark::RegisterBenchmark(
            ("stream/" + name + (noisy ? "/sensor_noise" : "/exact") + "/threads:" + std::to_string(threads)).c_str(),
            bench_stream, named, preset.image, noisy ? sim::SensorNoise{0.001, 0.1} : sim::SensorNoise{}, threads)
            ->UseManualTime()
            ->Unit(benchmark::kMillisecond);
      }
    }
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
}
