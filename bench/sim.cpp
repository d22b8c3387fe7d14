// Speed of what makes a training image, on one thread: trials, their vestibular noise, windows' FFTs, whole images,
// for each instruction set, each beside what it is measured against in the same run: the machine's peak (of fused
// multiply-adds in double, or of memory), trials also beside the plain loop, FFTs beside FFTW.
#include <benchmark/benchmark.h>
#include <omp.h>

#include <cmath>
#include <functional>
#include <span>
#include <vector>

#include "bench/counters.hpp"
#include "bench/plain_trial.hpp"
#include "bench/trials.hpp"
#include "dataset/image/image.hpp"
#include "identify/training/presets.hpp"
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
using bench::FmaPeak;

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
double fft_flops(double length) {
  return 2.5 * length * std::log2(length);
}

/// Of operations in double, of which a register holds half as many as of the peak's floats.
void count_flops(benchmark::State& state, const FmaPeak& peak, double flops, double seconds) {
  bench::count_flops(state, peak.best() / 2, flops, seconds);
}

/// Trials of the data set's distribution, 160 at once: ten for each lane. Beside the plain loop, one after the other,
/// with noise of its own for each as well. Operations are those of the steps alone.
void bench_trials(benchmark::State& state, Isa isa, bool noise) {
  constexpr int count = 160;
  const sim::Simulator simulator(sim::default_protocol(), isa);
  const auto trial_of = [noise](int index) { return bench::trial_of(index, noise); };
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
  FmaPeak peak(name(isa));
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
  count_flops(state, peak, bench::flops_per_step * trial_s * sim::steps_per_second, seconds);
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

/// The noise of a trial: 242 normals, an inverse FFT of 12,100 samples, whose operations count. Of eight trials at
/// once.
void bench_noise(benchmark::State& state, Isa isa) {
  const sim::Protocol protocol = sim::default_protocol();
  const sim::VestibularNoiseMaker maker(protocol);
  const std::vector<double> nv(sim::fft_lanes, 0.5);
  std::vector<Random> random;
  for (std::uint64_t i = 0; i < nv.size(); ++i) random.emplace_back(1, Stream::vestibular_noise, i);
  std::vector<double> rates((static_cast<std::size_t>(protocol.samples()) + 1) * nv.size());
  FmaPeak peak(name(isa));
  const double seconds =
      best_seconds(state, peak, [&] { maker.velocity_lanes(nv, random, rates, isa); }) / sim::fft_lanes;
  state.counters["us/trial"] = seconds * 1e6;
  count_flops(state, peak, fft_flops(protocol.samples()), seconds);
}

/// The sensor's noise of a trial, beside what memory could take of it.
void bench_normals(benchmark::State& state, Isa isa) {
  std::vector<double> values(12100);
  bench::Bandwidth bandwidth;
  const double seconds =
      best_seconds(state, bandwidth, [&] { Random(1, Stream::sensor_noise, 0).fill_normal(values, 1, isa); });
  state.counters["us/trial"] = seconds * 1e6;
  state.counters["ns/number"] = seconds / static_cast<double>(values.size()) * 1e9;
  bench::count_bytes(state, bandwidth, 8.0 * static_cast<double>(values.size()), seconds);
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
  FmaPeak peak(name(isa));
#if defined(DECID_FFTW)
  FftwWindows fftw(windows, length);
#endif
  std::vector<double> peer_times;
  const double seconds = best_seconds(state, peak, [&] {
    for (std::size_t i = 0; i < blocks; ++i) {
      fft.forward_lanes(std::span(in).subspan(i * in_size, in_size), std::span(out).subspan(i * out_size, out_size),
                        work, isa);
    }
  });
  state.counters["us"] = seconds * 1e6;
  count_flops(state, peak, windows * fft_flops(length), seconds);
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

/// The image of a trial, made with `trials` others of its kind. Beside its FFTs (fft/110x110), whose operations count:
/// real_imaginary adds copies, the others their functions.
void bench_image(benchmark::State& state, const dataset::ImageSettings& settings, std::size_t trials, Isa isa) {
  constexpr int samples = 12100;
  const dataset::ImageMaker maker(settings, samples);
  std::vector<float> sway_rad(samples), image(trials * static_cast<std::size_t>(maker.shape().size()));
  for (std::size_t i = 0; i < sway_rad.size(); ++i) sway_rad[i] = 1e-4F * static_cast<float>(i * 7919 % 100);
  FmaPeak peak(name(isa));
  const std::vector<std::span<const float>> sways(trials, sway_rad);
  const double seconds =
      best_seconds(state, peak, [&] { maker.make_all(sways, image, isa); }) / static_cast<double>(trials);
  state.counters["us"] = seconds * 1e6;
  state.counters["images/s"] = 1 / seconds;
  state.counters["ns/value"] = seconds / maker.shape().size() * 1e9;
  count_flops(state, peak, samples / settings.window * fft_flops(settings.window), seconds);
}

}  // namespace

int main(int argc, char** argv) {
  using dataset::Channel;
  const auto add = [](const std::string& what, Isa isa, auto run, auto... arguments) {
    benchmark::RegisterBenchmark((name(isa) + ("/" + what)).c_str(), run, arguments...)->UseManualTime();
  };
  const dataset::ImageSettings paper = preset_named("paper").image;
  const dataset::ImageSettings copies{.channels = {Channel::real, Channel::imaginary}};
  for (const Isa isa : available_isas()) {
    add("trials", isa, bench_trials, isa, true);
    add("trials_without_noise", isa, bench_trials, isa, false);
    add("vestibular_noise", isa, bench_noise, isa);
    add("sensor_noise", isa, bench_normals, isa);
    add("fft/110x110", isa, bench_fft, 110, isa);
    add("fft/110x100", isa, bench_fft, 100, isa);
    add("image/modulus_phase", isa, bench_image, paper, 1U, isa);
    add("image/real_imaginary", isa, bench_image, copies, 1U, isa);
    add("image/best", isa, bench_image, preset_named("best").image, 1U, isa);
    add("image/best/trials:8", isa, bench_image, preset_named("best").image, 8U, isa);
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
}
