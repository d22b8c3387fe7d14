// The engine's convolutions beside those of oneDNN (its own blocked layouts, f32) in one process: the same shapes,
// batch 32, one thread, CPU time, turn by turn. Prints a line each for `compare`: name, ours, theirs and the bound in
// GFLOP/s, and the limit that makes the bound, "arithmetic" or "memory", both measured between the repetitions. Input
// gradients of first layers are left out: training needs none.
#include <omp.h>

#include <algorithm>
#include <cstdio>
#include <dnnl.hpp>
#include <unordered_map>
#include <vector>

#include "bench/nn/convolutions.hpp"

namespace {

using namespace decid::bench;
using dnnl::memory;
using Arguments = std::unordered_map<int, memory>;

/// A primitive with memory in the layouts that it asks for.
class Theirs {
 public:
  Theirs(const dnnl::engine& engine, const Conv2dShape& s, Direction direction) : stream_(engine) {
    const auto any = [](memory::dims dims) {
      return memory::desc(std::move(dims), memory::data_type::f32, memory::format_tag::any);
    };
    const memory::desc src = any({blocks * lanes, s.src_channels, s.src_rows, s.src_columns}),
                       dst = any({blocks * lanes, s.dst_channels, s.dst_rows, s.dst_columns}),
                       weight = any({s.dst_channels, s.src_channels, s.kernel_rows, s.kernel_columns}),
                       bias = any({s.dst_channels});
    const memory::dims strides{s.stride_rows, s.stride_columns}, pad{s.pad_rows, s.pad_columns},
        // Values left over at the end of strides are not padded.
        pad_end{(s.dst_rows - 1) * s.stride_rows + s.kernel_rows - s.src_rows - s.pad_rows,
                (s.dst_columns - 1) * s.stride_columns + s.kernel_columns - s.src_columns - s.pad_columns};
    const auto algorithm = dnnl::algorithm::convolution_direct;
    const dnnl::convolution_forward::primitive_desc forward(
        {dnnl::prop_kind::forward_training, algorithm, src, weight, bias, dst, strides, pad, pad_end}, engine);
    const auto fill = [&](const memory::desc& desc) {
      memory m(desc, engine);
      auto* const values = static_cast<float*>(m.get_data_handle());
      for (std::size_t i = 0; i < desc.get_size() / sizeof(float); ++i)
        values[i] = static_cast<float>(i * 7919 % 1000) * 0.001F - 0.45F;
      return m;
    };
    if (direction == Direction::forward) {
      primitive_ = dnnl::convolution_forward(forward);
      arguments_ = {{DNNL_ARG_SRC, fill(forward.src_desc())},
                    {DNNL_ARG_WEIGHTS, fill(forward.weights_desc())},
                    {DNNL_ARG_BIAS, fill(forward.bias_desc())},
                    {DNNL_ARG_DST, fill(forward.dst_desc())}};
    } else if (direction == Direction::backward_src) {
      const dnnl::convolution_backward_data::primitive_desc backward(
          {algorithm, src, weight, dst, strides, pad, pad_end}, engine, forward);
      primitive_ = dnnl::convolution_backward_data(backward);
      arguments_ = {{DNNL_ARG_DIFF_SRC, fill(backward.diff_src_desc())},
                    {DNNL_ARG_WEIGHTS, fill(backward.weights_desc())},
                    {DNNL_ARG_DIFF_DST, fill(backward.diff_dst_desc())}};
    } else {
      const dnnl::convolution_backward_weights::primitive_desc backward(
          {algorithm, src, weight, bias, dst, strides, pad, pad_end}, engine, forward);
      primitive_ = dnnl::convolution_backward_weights(backward);
      arguments_ = {{DNNL_ARG_SRC, fill(backward.src_desc())},
                    {DNNL_ARG_DIFF_WEIGHTS, fill(backward.diff_weights_desc())},
                    {DNNL_ARG_DIFF_BIAS, fill(backward.diff_bias_desc())},
                    {DNNL_ARG_DIFF_DST, fill(backward.diff_dst_desc())}};
    }
  }
  void run() {
    primitive_.execute(stream_, arguments_);
    stream_.wait();
  }

 private:
  dnnl::stream stream_;
  dnnl::primitive primitive_;
  Arguments arguments_;
};

/// Bytes between memory and the caches if each tensor that is read moves once, and each that is written twice: a store
/// first reads its line.
double moved_bytes(const Conv2dShape& s, Direction direction) {
  const double src = 4.0 * blocks * lanes * s.src_channels * s.src_rows * s.src_columns,
               dst = 4.0 * blocks * lanes * s.dst_channels * s.dst_rows * s.dst_columns;
  if (direction == Direction::forward) return src + 2 * dst;
  return direction == Direction::backward_src ? dst + 2 * src : src + dst;
}

void compare(const dnnl::engine& engine, const Conv& conv, Direction direction, Bandwidth& bandwidth) {
  constexpr double seconds_a_side = 0.5;
  ConvRun ours(conv.shape);
  Theirs theirs(engine, conv.shape, direction);
  const Kernels<float>& kernels = decid::nn::kernels<float>();
  const double flops = ours.channel_flops(direction) * ours.channels(direction) * blocks;
  std::vector<double> our_times, their_times;
  FmaPeak peak(kernels.name);
  theirs.run();
  for (double spent = 0; spent < seconds_a_side || our_times.size() < 5; spent += our_times.back()) {
    our_times.push_back(seconds_of([&] { ours.run_batch(kernels, direction); }));
    their_times.push_back(seconds_of([&] { theirs.run(); }));
    peak.measure();
  }
  bandwidth.measure();
  const double memory = flops / moved_bytes(conv.shape, direction) * bandwidth.best();
  constexpr const char* directions[] = {"forward", "input gradient", "weight gradient"};
  std::printf("%s %s\t%.1f\t%.1f\t%.1f\t%s\n", conv.name, directions[static_cast<int>(direction)],
              flops / best_of(our_times) * 1e-9, flops / best_of(their_times) * 1e-9, std::min(memory, peak.best()),
              memory < peak.best() ? "memory" : "arithmetic");
  std::fflush(stdout);
}

const char* full_name(dnnl::cpu_isa isa) {
  switch (isa) {
    case dnnl::cpu_isa::avx2:
      return "avx2";
    case dnnl::cpu_isa::avx2_vnni:
      return "avx2_vnni";
    case dnnl::cpu_isa::avx512_core:
      return "avx512_core";
    case dnnl::cpu_isa::avx512_core_vnni:
      return "avx512_core_vnni";
    case dnnl::cpu_isa::avx512_core_bf16:
      return "avx512_core_bf16";
    case dnnl::cpu_isa::avx512_core_amx:
      return "avx512_core_amx";
    default:
      return "another";
  }
}

}  // namespace

int main() {
  omp_set_num_threads(1);
  const dnnl::version_t& version = *dnnl::version();
  std::printf("oneDNN %d.%d.%d, instruction set %s; ours %s\n", version.major, version.minor, version.patch,
              full_name(dnnl::get_effective_cpu_isa()), decid::nn::kernels<float>().name);
  const dnnl::engine engine(dnnl::engine::kind::cpu, 0);
  Bandwidth bandwidth;
  for (int i = 0; i < 5; ++i) bandwidth.measure();
  for (const Conv& conv : convs)
    for (const Direction d : {Direction::forward, Direction::backward_src, Direction::backward_weight})
      if (d != Direction::backward_src || conv.shape.src_channels > 2) compare(engine, conv, d, bandwidth);
}
