// Speed of what makes a training image, on one thread: trials, their vestibular noise, windows' FFTs, whole images,
// for each instruction set, each beside what it is measured against in the same run: trials beside the plain loop, FFTs
// beside how many multiplications and additions a second one core can do one at a time, and beside FFTW.
#include <benchmark/benchmark.h>
#include <omp.h>

#include <cmath>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "bench/machine.hpp"
#include "bench/plain_trial.hpp"
#include "dataset/image.hpp"
#include "sim/noise.hpp"
#include "sim/simulate.hpp"

#if defined(DECID_FFTW)
#include <fftw3.h>

#include <complex>
#endif

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
  Scalar<12> throughput;  // 4 a cycle x 3 cycles
  void measure() { throughput.measure(); }
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

/// Trials of the data set's distribution, 160 at once: ten for each lane. Beside the plain loop, one after the other,
/// with noise of its own for each as well; and beside what 24 multiplications and additions a step would take, 12 of
/// them fused, if nothing else did.
void bench_trials(benchmark::State& state, Isa isa, bool noise) {
  constexpr int count = 160;
  const sim::Simulator simulator(sim::default_protocol(), isa);
  const auto trial_of = [&](int index) {
    const auto item = static_cast<std::uint64_t>(index);
    const Random random(1, Stream::base_parameters, item);
    sim::Parameters parameters{};
    for (std::size_t i = 0; i < sim::parameter_count; ++i) {
      parameters[i] = random.uniform(i, sim::parameter_info[i].low, sim::parameter_info[i].high);
    }
    if (!noise) parameters[sim::Nv] = 0;
    return sim::Trial{parameters, Random(1, Stream::vestibular_noise, item)};
  };
  const sim::VestibularNoiseMaker maker(simulator.protocol());
  const auto samples = static_cast<std::size_t>(simulator.samples());
  std::vector<double> noise_rate(samples + 1), sway_rad(samples);
  std::vector<double> plain_times;
  int plain_index = 0;
  const auto run_plain = [&] {
    // A whole trial: those that fall would make it look cheaper.
    for (;; ++plain_index) {
      const sim::Trial trial = trial_of(plain_index % count);
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
  double simulated_s = 0.0;
  std::vector<double> times;
  const auto run = [&] {
    simulated_s = 0.0;
    const double start = cpu_seconds();
    simulator.run_all(count, trial_of,
                      [&](int, const sim::Outcome& outcome, std::span<double>) { simulated_s += outcome.end_s; });
    times.push_back(cpu_seconds() - start);
  };
  run();
  for (auto _ : state) {
    run();
    for (int i = 0; i < 4; ++i) run_plain();
    state.SetIterationTime(times.back());
  }
  const double trial_s = simulator.protocol().duration_s();
  const double whole_trials = simulated_s / trial_s, seconds = best_of(times) / whole_trials;
  state.counters["trials/s"] = 1 / seconds;
  state.counters["us/trial"] = seconds * 1e6;
  state.counters["ns/step"] = seconds / (trial_s * sim::steps_per_second) * 1e9;
  state.counters["plain us"] = best_of(plain_times) * 1e6;
  state.counters["x plain"] = best_of(plain_times) / seconds;
}

#if defined(DECID_FFTW)
/// The same windows by FFTW in float, planned by measurement.
class FftwWindows {
 public:
  FftwWindows(int windows, int length)
      : in_(static_cast<std::size_t>(windows * length), 0.5F),
        out_(static_cast<std::size_t>(windows) * static_cast<std::size_t>(length / 2 + 1)) {
    const auto out = reinterpret_cast<fftwf_complex*>(out_.data());
    plan_ = fftwf_plan_many_dft_r2c(1, &length, windows, in_.data(), nullptr, 1, length, out, nullptr, 1,
                                    length / 2 + 1, FFTW_PATIENT);
    for (std::size_t i = 0; i < in_.size(); ++i) in_[i] = 0.01F * static_cast<float>(i * 7919 % 100);
  }
  ~FftwWindows() { fftwf_destroy_plan(plan_); }
  FftwWindows(const FftwWindows&) = delete;
  FftwWindows& operator=(const FftwWindows&) = delete;
  void run() { fftwf_execute(plan_); }

 private:
  std::vector<float> in_;
  std::vector<std::complex<float>> out_;
  fftwf_plan plan_;
};
#endif

/// Operations of a real FFT as FFTW counts them.
double fft_flops(double length) {
  return 2.5 * length * std::log2(length);
}

void count_flops(benchmark::State& state, const Machine& machine, double flops, double seconds) {
  state.counters["GFLOP/s"] = flops / seconds * 1e-9;
  state.counters["peak"] = 1e-9 / machine.throughput.best();
  state.counters["%peak"] = 100 * flops * machine.throughput.best() / seconds;
}

/// The noise of a trial: 242 normals, an inverse FFT of 12,100 samples. Of eight trials at once.
void bench_noise(benchmark::State& state, Isa isa) {
  const sim::Protocol protocol = sim::default_protocol();
  const sim::VestibularNoiseMaker maker(protocol);
  const std::vector<double> nv(sim::fft_lanes, 0.5);
  std::vector<Random> random;
  for (std::uint64_t i = 0; i < nv.size(); ++i) random.emplace_back(1, Stream::vestibular_noise, i);
  std::vector<double> rates((static_cast<std::size_t>(protocol.samples()) + 1) * nv.size());
  Machine machine;
  const double seconds =
      best_seconds(state, machine, [&] { maker.velocity_lanes(nv, random, rates, isa); }) / sim::fft_lanes;
  state.counters["us/trial"] = seconds * 1e6;
}

/// The sensor's noise of a trial.
void bench_normals(benchmark::State& state, Isa isa) {
  std::vector<double> values(12100);
  Machine machine;
  const double seconds =
      best_seconds(state, machine, [&] { Random(1, Stream::sensor_noise, 0).fill_normal(values, 1, isa); });
  state.counters["us/trial"] = seconds * 1e6;
  state.counters["ns/number"] = seconds / static_cast<double>(values.size()) * 1e9;
}

/// All windows of a trial, in double; FFTW does them in float, which is half the memory and half the work.
void bench_fft(benchmark::State& state, int length, Isa isa) {
  constexpr int windows = 110;
  constexpr std::size_t lanes = sim::fft_lanes, blocks = (windows + lanes - 1) / lanes;
  const sim::RealFft fft(length);
  const auto in_size = static_cast<std::size_t>(length) * lanes,
             out_size = static_cast<std::size_t>(2 * fft.bins()) * lanes;
  std::vector<double> in(blocks * in_size), out(blocks * out_size);
  std::vector<double> work(2 * static_cast<std::size_t>(fft.work_length()) * lanes);
  for (std::size_t i = 0; i < in.size(); ++i) in[i] = 0.01 * static_cast<double>(i * 7919 % 100);
  Machine machine;
#if defined(DECID_FFTW)
  FftwWindows fftw(windows, length);
#endif
  std::vector<double> peer_times;
  const double seconds = best_seconds(state, machine, [&] {
    for (std::size_t i = 0; i < blocks; ++i) {
      fft.forward_lanes(std::span(in).subspan(i * in_size, in_size), std::span(out).subspan(i * out_size, out_size),
                        work, isa);
    }
  });
  state.counters["us"] = seconds * 1e6;
  count_flops(state, machine, windows * fft_flops(length), seconds);
#if defined(DECID_FFTW)
  for (int i = 0; i < 200; ++i) {
    const double start = cpu_seconds();
    fftw.run();
    peer_times.push_back(cpu_seconds() - start);
  }
  state.counters["fftw us"] = best_of(peer_times) * 1e6;
  state.counters["fftw/ours"] = best_of(peer_times) / seconds;
#endif
}

/// The image of a trial. Beside its FFTs (fft/110x110): real_imaginary adds copies, the others their functions.
void bench_image(benchmark::State& state, const dataset::ImageSettings& settings, Isa isa) {
  constexpr int samples = 12100;
  const dataset::ImageMaker maker(settings, samples);
  std::vector<float> sway_rad(samples), image(static_cast<std::size_t>(maker.shape().size()));
  for (std::size_t i = 0; i < sway_rad.size(); ++i) sway_rad[i] = 1e-4F * static_cast<float>(i * 7919 % 100);
  Machine machine;
  const double seconds = best_seconds(state, machine, [&] { maker.make(sway_rad, image, isa); });
  state.counters["us"] = seconds * 1e6;
  state.counters["images/s"] = 1 / seconds;
  state.counters["ns/value"] = seconds / maker.shape().size() * 1e9;
}

}  // namespace

int main(int argc, char** argv) {
  using dataset::Channel;
  const auto add = [](const std::string& what, Isa isa, auto run, auto... arguments) {
    benchmark::RegisterBenchmark((name(isa) + ("/" + what)).c_str(), run, arguments...)->UseManualTime();
  };
  const dataset::ImageSettings paper{.channels = {Channel::modulus, Channel::phase}};
  const dataset::ImageSettings copies{.channels = {Channel::real, Channel::imaginary}};
  const dataset::ImageSettings folded{
      .half_spectrum = true,
      .channels = {Channel::asinh_real, Channel::asinh_imaginary, Channel::log_modulus, Channel::log_residual},
      .fold = 2};
  for (const Isa isa : available_isas()) {
    add("trials", isa, bench_trials, isa, true);
    add("trials_without_noise", isa, bench_trials, isa, false);
    add("vestibular_noise", isa, bench_noise, isa);
    add("sensor_noise", isa, bench_normals, isa);
    add("fft/110x110", isa, bench_fft, 110, isa);
    add("fft/110x100", isa, bench_fft, 100, isa);
    add("image/modulus_phase", isa, bench_image, paper, isa);
    add("image/real_imaginary", isa, bench_image, copies, isa);
    add("image/folded", isa, bench_image, folded, isa);
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
}
