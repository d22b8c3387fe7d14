// Speed of the vestibular noise of trials, on one thread, for each instruction set, beside the machine's peak of fused
// multiply-adds in double.
#include "sim/noise.hpp"

#include <benchmark/benchmark.h>

#include <vector>

#include "bench/isas.hpp"
#include "sim/streams.hpp"

namespace {

using namespace decid;
using namespace decid::bench;

/// Noise of eight trials at once. Each takes 482 normals and an inverse FFT over a period of 24,200 samples; only
/// operations of the FFT count.
void bench_noise(benchmark::State& state, Isa isa) {
  const sim::Protocol protocol = sim::default_protocol();
  const sim::VestibularNoiseMaker maker(protocol);
  const std::vector<double> nv(sim::fft_lanes, 0.5);
  std::vector<Random> random;
  for (std::uint64_t i = 0; i < nv.size(); ++i) random.emplace_back(1, sim::streams::vestibular_noise, i);
  std::vector<double> rates((static_cast<std::size_t>(protocol.samples()) + 1) * nv.size());
  FmaPeak peak(name(isa));
  const double seconds =
      best_seconds(state, peak, [&] { maker.velocity_lanes(nv, random, rates, isa); }) / sim::fft_lanes;
  state.counters["us/trial"] = seconds * 1e6;
  count_double_flops(state, peak, fft_flops(protocol.noise_period_samples()), seconds);
}

[[maybe_unused]] const bool registered = [] {
  add_for_each_isa("vestibular_noise", bench_noise);
  return true;
}();

}  // namespace
