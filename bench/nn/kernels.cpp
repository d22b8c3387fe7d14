// Speed of the engine's kernels on one thread: convolutions in GFLOP/s and % of the machine's multiply-add peak, the
// others in GB/s and % of its bandwidth, each kernel also as the plain definition. Batches of 32 samples, channels in
// the groups that layers pass, so that data comes from where it would in training. Figures are the best of the
// repetitions.
#include "nn/kernels/kernels.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include "bench/counters.hpp"
#include "bench/nn/convolutions.hpp"
#include "bench/nn/planes.hpp"

namespace {

using namespace decid;
using namespace decid::nn;
using namespace decid::bench;

/// Returns the best time of `run` in s; the machine is measured before each.
template <class Machine>
double best_time(benchmark::State& state, Machine& machine, const std::function<void()>& run) {
  std::vector<double> times;
  for (auto _ : state) {
    machine.measure();
    times.push_back(seconds_of(run));
    state.SetIterationTime(times.back());
  }
  return best_of(times);
}

void bench_conv(benchmark::State& state, const Conv2dShape& shape, Direction direction, Isa isa) {
  const Kernels<float>& kernels = kernels_for(isa);
  ConvRun conv(shape);
  FmaPeak peak(name(isa));
  const double reference = conv.channel_flops(direction) /
                           seconds_of([&] { conv.run(reference_kernels<float>(), direction, 0, 0, 1); }) * 1e-9;
  const double flops = conv.channel_flops(direction) * conv.channels(direction) * blocks;
  const double seconds = best_time(state, peak, [&] { conv.run_batch(kernels, direction); });
  count_flops(state, peak.best(), flops, seconds);
  state.counters["reference"] = reference;
}

/// 64 channels of 110 x 110, 198 MB with both blocks: from memory, as after the first convolution of a large network.
void bench_plane(benchmark::State& state, const PlaneKernel& kernel, Isa isa) {
  const Shape shape{64, 110, 110};
  const Batch x(shape, {1, 1}), dy(shape, {1, 1}), pooled({64, 55, 55}, {1, 1});
  Bandwidth bandwidth;
  const auto run = [&](const Kernels<float>& k, int channels) {
    for (int b = 0; b < blocks; ++b)
      for (int c = 0; c < channels; ++c) kernel.run(k, x, dy, pooled, b, c);
  };
  const auto bytes = [&](int channels) {
    return kernel.bytes * blocks * channels * lanes * shape.rows * shape.columns;
  };
  const double reference = bytes(4) / seconds_of([&] { run(reference_kernels<float>(), 4); }) * 1e-9;
  const double seconds = best_time(state, bandwidth, [&] { run(kernels_for(isa), shape.channels); });
  count_bytes(state, bandwidth, bytes(shape.channels), seconds);
  state.counters["reference"] = reference;
}

/// First-layer and last-layer sizes of the reference networks: rows of 23328 weights for 7 outputs.
void bench_dense(benchmark::State& state, int direction, Isa isa) {
  const Shape shape{32, 27, 27};
  constexpr int outputs = 7;
  const Batch src(shape, {1, 1}), diff_src(shape, {1, 1});
  std::vector<float> weight(static_cast<std::size_t>(outputs * shape.size()), 0.01F), bias(outputs),
      dst(outputs * lanes);
  const auto run = [&](const Kernels<float>& k, int b) {
    if (direction == 0)
      k.fully_connected_forward(shape, src.const_block(b), weight.data(), bias.data(), dst.data(), 0, outputs);
    else if (direction == 1)
      k.fully_connected_backward_src(shape, outputs, dst.data(), weight.data(), diff_src.block(b), 0, shape.channels);
    else
      k.fully_connected_backward_weight(shape, src.const_block(b), dst.data(), lanes, weight.data(), bias.data(), 0,
                                        outputs);
  };
  const double flops = 2.0 * lanes * outputs * shape.size();
  const double reference = flops / seconds_of([&] { run(reference_kernels<float>(), 0); }) * 1e-9;
  FmaPeak peak(name(isa));
  const double seconds = best_time(state, peak, [&] {
    for (int b = 0; b < blocks; ++b) run(kernels_for(isa), b);
  });
  count_flops(state, peak.best(), flops * blocks, seconds);
  state.counters["reference"] = reference;
}

/// The other layout, output channels in the lanes, as single samples have it: 32 samples one after the other.
void bench_conv_single(benchmark::State& state, const Conv2dShape& s, Isa isa) {
  const int dst_blocks = (s.dst_channels + lanes - 1) / lanes;
  const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(s.src_columns + 2 * s.pad_columns) * lanes;
  const std::ptrdiff_t plane = row * (s.src_rows + 2 * s.pad_rows);
  const std::ptrdiff_t dst_row = static_cast<std::ptrdiff_t>(s.dst_columns) * lanes;
  std::vector<std::ptrdiff_t> offset;
  for (int c = 0; c < s.src_channels; ++c)
    for (int ky = 0; ky < s.kernel_rows; ++ky)
      for (int kx = 0; kx < s.kernel_columns; ++kx)
        offset.push_back(c / lanes * plane + ky * row + kx * lanes + c % lanes);
  const auto values = [](std::ptrdiff_t count) {
    AlignedBuffer<float> buffer;
    buffer.reserve(static_cast<std::size_t>(count));
    for (std::size_t i = 0; i < buffer.size(); ++i) buffer.data()[i] = static_cast<float>(i % 1000) * 0.001F - 0.45F;
    return buffer;
  };
  const int taps = static_cast<int>(offset.size()), samples = blocks * lanes;
  const std::ptrdiff_t src_size = (s.src_channels + lanes - 1) / lanes * plane;
  const std::ptrdiff_t dst_size = dst_blocks * dst_row * s.dst_rows;
  AlignedBuffer<float> dst = values(dst_size * samples);
  const AlignedBuffer<float> src = values(src_size * samples),
                             weight = values(static_cast<std::ptrdiff_t>(dst_blocks) * taps * lanes),
                             bias = values(static_cast<std::ptrdiff_t>(dst_blocks) * lanes);
  const double flops = 2.0 * samples * s.dst_channels * s.dst_rows * s.dst_columns * taps;
  FmaPeak peak(name(isa));
  const double seconds = best_time(state, peak, [&] {
    for (int n = 0; n < samples; ++n)
      kernels_for(isa).conv2d_single(
          {s.dst_rows, s.dst_columns, src.data() + n * src_size, s.stride_rows * row,
           static_cast<std::ptrdiff_t>(s.stride_columns) * lanes, offset.data(), taps, weight.data(), bias.data(),
           dst.data() + n * dst_size, dst_row * s.dst_rows, dst_row},
          0, dst_blocks);
  });
  count_flops(state, peak.best(), flops, seconds);
}

}  // namespace

int main(int argc, char** argv) {
  constexpr const char* directions[] = {"forward", "backward_src", "backward_weight"};
  for (const Isa isa : available_isas()) {
    if (isa == Isa::reference) continue;
    const auto prefix = [&](const char* kind) { return std::string(name(isa)) + "/" + kind + "/"; };
    for (const Conv& conv : convs)
      for (int d = 0; d < 3; ++d)
        benchmark::RegisterBenchmark((prefix("conv2d") + conv.name + "/" + directions[d]).c_str(), bench_conv,
                                     conv.shape, static_cast<Direction>(d), isa)
            ->UseManualTime();
    for (const Conv& conv : convs)
      benchmark::RegisterBenchmark((prefix("conv2d") + conv.name + "/forward_channels_in_lanes").c_str(),
                                   bench_conv_single, conv.shape, isa)
          ->UseManualTime();
    for (const PlaneKernel& kernel : plane_kernels)
      benchmark::RegisterBenchmark((prefix("plane") + kernel.name).c_str(), bench_plane, kernel, isa)->UseManualTime();
    for (int d = 0; d < 3; ++d)
      benchmark::RegisterBenchmark((prefix("dense") + directions[d]).c_str(), bench_dense, d, isa)->UseManualTime();
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
}
