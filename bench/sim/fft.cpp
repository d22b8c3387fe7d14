// Speed of the FFTs of a trial's windows, on one thread, for each instruction set, beside the machine's peak of fused
// multiply-adds in double and beside FFTW.
#include "sim/fft.hpp"

#include <benchmark/benchmark.h>

#include <span>
#include <vector>

#include "bench/isas.hpp"

#if defined(DECID_FFTW)
#include <fftw3.h>

#include <complex>
#endif

namespace {

using namespace decid;
using namespace decid::bench;

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
  count_double_flops(state, peak, windows * fft_flops(length), seconds);
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

[[maybe_unused]] const bool registered = [] {
  for (const int length : {110, 100}) add_for_each_isa("fft/110x" + std::to_string(length), bench_fft, length);
  return true;
}();

}  // namespace
