// Speed of what makes a training image, on one thread: trials, their vestibular noise, windows' FFTs, whole images,
// each beside what bounds it on this machine, measured in the same run: the latency of dependent multiplications and
// additions in double, or how many a second there can be. Library code is scalar double; its bits allow no other order.
#include <benchmark/benchmark.h>

#include <cmath>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "bench/machine.hpp"
#include "dataset/image.hpp"
#include "sim/noise.hpp"
#include "sim/simulate.hpp"

namespace {

using namespace decid;
using bench::best_of;
using bench::cpu_seconds;

#if defined(__aarch64__)
#define DECID_FLOAT_REGISTER "+w"
#else
#define DECID_FLOAT_REGISTER "+x"
#endif

/// `chains` independent chains of x = x a + b, not fused, as double: seconds an operation.
template <int chains>
class Scalar {
 public:
  void measure() {
    constexpr int rounds = 20000;
    double a = 0.999, b = 0.001;
    asm volatile("" : DECID_FLOAT_REGISTER(a), DECID_FLOAT_REGISTER(b));
    const double start = cpu_seconds();
    const auto step = [&](double& x) {
      x = x * a + b;
      asm volatile("" : DECID_FLOAT_REGISTER(x));
    };
    bench::run_chains(rounds, 1.0, step, std::make_index_sequence<chains>());
    times_.push_back((cpu_seconds() - start) / (2.0 * chains * rounds));
  }
  double best() const { return best_of(times_); }

 private:
  std::vector<double> times_;
};

struct Machine {
  Scalar<1> latency;      // one after the other
  Scalar<12> throughput;  // 4 a cycle x 3 cycles
  void measure() {
    latency.measure();
    throughput.measure();
  }
};

/// Seconds of the best run; the machine is measured now and then in between.
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

/// A trial of 121,000 steps of 1 ms. From one step's sway to the next's lead 14 operations, each waiting for the one
/// before: 8 to sin(sway), 2 to the torque, 4 to the velocity and the sway.
void bench_trial(benchmark::State& state, bool noise) {
  constexpr double chain = 14;
  const sim::Simulator simulator(sim::default_protocol());
  sim::Parameters parameters = sim::middle_parameters();
  if (!noise) parameters[sim::Nv] = 0;
  std::vector<double> sway_rad(static_cast<std::size_t>(simulator.samples()));
  std::uint64_t item = 0;
  bool valid = true;
  Machine machine;
  const double seconds = best_seconds(state, machine, [&] {
    valid =
        simulator.run(parameters, Random(1, Stream::vestibular_noise, noise ? item++ % 4 : 0), sway_rad).valid && valid;
  });
  if (!valid) state.SkipWithError("a trial left its bound: less than a trial was timed");
  const double steps = simulator.samples() * static_cast<double>(simulator.protocol().steps_per_sample());
  state.counters["trials/s"] = 1 / seconds;
  state.counters["ns/step"] = seconds / steps * 1e9;
  state.counters["bound ns"] = chain * machine.latency.best() * 1e9;
  state.counters["%bound"] = 100 * chain * machine.latency.best() * steps / seconds;
}

/// Operations of a real FFT as FFTW counts them.
double fft_flops(double length) {
  return 2.5 * length * std::log2(length);
}

void count_flops(benchmark::State& state, const Machine& machine, double flops, double seconds) {
  state.counters["GFLOP/s"] = flops / seconds * 1e-9;
  state.counters["peak"] = 1e-9 / machine.throughput.best();
  state.counters["%peak"] = 100 * flops * machine.throughput.best() / seconds;
}

/// The noise of a trial: 240 normals, an inverse FFT of 12,100 samples.
void bench_noise(benchmark::State& state) {
  const sim::Protocol protocol = sim::default_protocol();
  const sim::VestibularNoiseMaker maker(protocol);
  std::vector<double> rate(static_cast<std::size_t>(protocol.samples()) + 1);
  Machine machine;
  const double seconds =
      best_seconds(state, machine, [&] { maker.velocity(0.5, Random(1, Stream::vestibular_noise, 0), rate); });
  state.counters["us"] = seconds * 1e6;
  count_flops(state, machine, fft_flops(protocol.samples()), seconds);
}

/// All windows of a trial.
void bench_fft(benchmark::State& state, int length) {
  constexpr std::size_t count = 110;
  const sim::RealFft fft(length);
  const auto step = static_cast<std::size_t>(length), bins = static_cast<std::size_t>(fft.bins());
  std::vector<double> in(count * step, 0.5);
  std::vector<sim::Complex> out(count * bins), work(static_cast<std::size_t>(fft.work_length()));
  for (std::size_t i = 0; i < in.size(); ++i) in[i] = 0.01 * static_cast<double>(i * 7919 % 100);
  Machine machine;
  const double seconds = best_seconds(state, machine, [&] {
    for (std::size_t i = 0; i < count; ++i)
      fft.forward(std::span(in).subspan(i * step, step), std::span(out).subspan(i * bins, bins), work);
  });
  state.counters["us"] = seconds * 1e6;
  count_flops(state, machine, count * fft_flops(length), seconds);
}

/// The image of a trial. Beside its FFTs (fft/110x110): real_imaginary adds copies, the others their functions.
void bench_image(benchmark::State& state, const std::vector<dataset::Channel>& channels) {
  constexpr int samples = 12100;
  dataset::ImageSettings settings;
  settings.channels = channels;
  const dataset::ImageMaker maker(settings, samples);
  std::vector<float> sway_rad(samples), image(static_cast<std::size_t>(maker.shape().size()));
  for (std::size_t i = 0; i < sway_rad.size(); ++i) sway_rad[i] = 1e-4F * static_cast<float>(i * 7919 % 100);
  Machine machine;
  const double seconds = best_seconds(state, machine, [&] { maker.make(sway_rad, image); });
  state.counters["us"] = seconds * 1e6;
  state.counters["images/s"] = 1 / seconds;
  state.counters["ns/value"] = seconds / maker.shape().size() * 1e9;
}

}  // namespace

int main(int argc, char** argv) {
  using dataset::Channel;
  const auto add = [](const char* name, auto run, auto... arguments) {
    benchmark::RegisterBenchmark(name, run, arguments...)->UseManualTime();
  };
  add("trial", bench_trial, true);
  add("trial/without_noise", bench_trial, false);
  add("noise", bench_noise);
  add("fft/110x110", bench_fft, 110);
  add("fft/110x100", bench_fft, 100);
  add("image/modulus_phase", bench_image, std::vector{Channel::modulus, Channel::phase});
  add("image/real_imaginary", bench_image, std::vector{Channel::real, Channel::imaginary});
  add("image/log_modulus", bench_image, std::vector{Channel::log_modulus});
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
}
