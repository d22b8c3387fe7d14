// Speed of the posterior's density with its gradient, of eight chains at once, on one thread, for each instruction set,
// beside the machine's peak of fused multiply-adds in double; and of its information matrix. Operations that count are
// those of the transforms: two of the bins, two of the blocks, two of the noise; and for the information those of the
// products of its columns. With 2 and 10 s that were not measured, the speed is relative to the same operations.
#include "posterior/density/density.hpp"

#include <benchmark/benchmark.h>

#include <vector>

#include "base/math/cholesky.hpp"
#include "bench/isas.hpp"
#include "posterior/streams.hpp"
#include "sim/simulate.hpp"
#include "sim/streams.hpp"

namespace {

using namespace decid;
using namespace decid::bench;
using posterior::Density;
using posterior::lanes;

struct Recorded {
  sim::Protocol protocol = sim::default_protocol();
  Density density;
  posterior::Observation observation;
  AlignedVector<double> x;
  Density::Workspace work;

  explicit Recorded(Isa isa, double missing_s = 0.0)
      : density(protocol, {}, isa),
        observation(density.observe(sway(), gaps(missing_s))),
        x(static_cast<std::size_t>(density.size()) * lanes),
        work(density) {
    Random(1, posterior::streams::chains, 0).fill_normal(x);
    for (double& value : x) value *= 0.3;
  }
  std::vector<float> sway() const {
    std::vector<double> sway_rad(static_cast<std::size_t>(protocol.samples()));
    sim::Simulator(protocol).run(protocol.parameters().middle(), Random(1, sim::streams::vestibular_noise, 0),
                                 sway_rad);
    return {sway_rad.begin(), sway_rad.end()};
  }
  /// One gap in the middle.
  std::vector<SampleRange> gaps(double missing_s) const {
    const auto length = static_cast<std::size_t>(missing_s * protocol.experiment.sample_rate_hz),
               first = static_cast<std::size_t>(protocol.samples() / 2);
    if (length == 0) return {};
    return {{first, first + length}};
  }
};

void bench_gradient(benchmark::State& state, double missing_s, Isa isa) {
  Recorded recorded(isa, missing_s);
  AlignedVector<double> gradient(recorded.x.size());
  std::vector<double> potential(lanes);
  FmaPeak peak(name(isa));
  const double seconds = best_seconds(state, peak, [&] {
    recorded.density.evaluate(recorded.observation, recorded.x, gradient, potential, recorded.work);
  });
  const Density::Transforms lengths = recorded.density.transforms();
  state.counters["us/chain"] = seconds * 1e6 / lanes;
  count_double_flops(state, peak,
                     2.0 * lanes * (2.0 * fft_flops(lengths.sway) + lengths.noise_count * fft_flops(lengths.noise)),
                     seconds);
}

void bench_information(benchmark::State& state, Isa isa) {
  Recorded recorded(isa);
  const auto size = static_cast<std::size_t>(recorded.density.size());
  std::vector<double> matrices(triangle(size) * lanes);
  FmaPeak peak(name(isa));
  const double seconds = best_seconds(
      state, peak, [&] { recorded.density.information(recorded.observation, recorded.x, matrices, recorded.work); });
  state.counters["ms"] = seconds * 1e3;
  const Density::Transforms lengths = recorded.density.transforms();
  const double columns = static_cast<double>(size);
  count_double_flops(state, peak,
                     lanes * columns * (2.0 * fft_flops(lengths.sway) + columns * recorded.density.blocks()), seconds);
}

[[maybe_unused]] const bool registered = [] {
  add_for_each_isa("posterior/gradient", bench_gradient, 0.0);
  add_for_each_isa("posterior/gradient_2_s_missing", bench_gradient, 2.0);
  add_for_each_isa("posterior/gradient_10_s_missing", bench_gradient, 10.0);
  add_for_each_isa("posterior/information", bench_information);
  return true;
}();

}  // namespace
