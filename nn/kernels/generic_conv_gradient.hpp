// Gradient of a convolution's weights: tiles of output channels x taps of accumulators, each one chain over all
// positions (i, j) in order; the lane tree comes last. Chains pause in a scratch between blocks of rows.
#pragma once

#include "nn/kernels/generic_lanes.hpp"

namespace decid::nn {
namespace {

constexpr int gradient_channels = 16;
/// Taps (channel, row and column of the kernel, flat) of a block at most: 14 channels of 3 x 3. Their accumulators for
/// 16 output channels, 130 KB, stay in a 1 MB second-level cache with the rows they meet.
constexpr int gradient_taps = 126;
/// Positions after which a tile pauses: diff_dst of 4 channels there is 28 KB, read from the first-level cache by
/// every tile of taps.
constexpr int gradient_positions = 112;

/// Accumulators of 16 lanes, [channel][tap]; in the first block of taps the bias counts as one more tap, the last.
struct GradientBlock {
  std::ptrdiff_t offset[gradient_taps];
  alignas(64) float acc[gradient_channels * (gradient_taps + 1) * lanes];
  float result[gradient_taps + 1];
  int taps, bias;
};

/// A tile's inputs at the first of its rows, and how far they reach.
struct GradientPlace {
  const float* src;
  std::ptrdiff_t src_row, src_column;
  const float* diff_dst;
  std::ptrdiff_t diff_channel, diff_row;
  int rows, columns;
  std::ptrdiff_t acc_channel;  // stride of accumulators
};

/// Q channels x T taps, and Q sums of diff_dst alone if Bias, of V::width lanes.
template <class V, int Q, int T, bool Bias>
void gradient_tile(const GradientPlace& tile_place, const std::ptrdiff_t* offset, float* acc_memory) {
  using Float = typename V::Float;
  const GradientPlace place = tile_place;
  constexpr int columns = T + (Bias ? 1 : 0);
  Float acc[Q][columns];
  unroll<Q>([&](auto q) {
    unroll<columns>([&](auto t) { acc[q][t] = V::load(acc_memory + q * place.acc_channel + t * lanes); });
  });
  for (int i = 0; i < place.rows; ++i) {
    const float* tap[T + 1];
    unroll<T>([&](auto t) { tap[t] = place.src + i * place.src_row + offset[t]; });
    const float* diff = place.diff_dst + i * place.diff_row;
    std::ptrdiff_t at_src = 0;
    for (int j = 0; j < place.columns; ++j, at_src += place.src_column, diff += lanes) {
      Float x[T + 1];
      unroll<T>([&](auto t) { x[t] = V::load(tap[t] + at_src); });
      unroll<Q>([&](auto q) {
        const Float dy = V::load(diff + q * place.diff_channel);
        unroll<T>([&](auto t) { acc[q][t] = V::fma(x[t], dy, acc[q][t]); });
        if constexpr (Bias) acc[q][T] = V::add(acc[q][T], dy);
      });
    }
  }
  unroll<Q>([&](auto q) {
    unroll<columns>([&](auto t) { V::store(acc_memory + q * place.acc_channel + t * lanes, acc[q][t]); });
  });
}

using GradientTile = void (*)(const GradientPlace&, const std::ptrdiff_t*, float*);

/// The tile for q channels and t taps, among which the bias counts if `bias`; each up to the vector type's own.
template <class V, int Q = V::tile_channels, int T = V::tile_columns>
GradientTile find_gradient_tile(int q, int t, bool bias) {
  if (q == Q && t == T) return bias ? gradient_tile<V, Q, T - 1, true> : gradient_tile<V, Q, T, false>;
  if constexpr (T > 1)
    if (t < T) return find_gradient_tile<V, Q, T - 1>(q, t, bias);
  if constexpr (Q > 1) return find_gradient_tile<V, Q - 1, T>(q, t, bias);
  return nullptr;
}

/// What a weight gradient reads, and its channels [first, first + count).
struct GradientTask {
  const Conv2dShape& shape;
  View<const float> src, diff_dst;
  int first, count;
};

/// All rows into the accumulators of a block of taps.
template <class V>
void accumulate_gradient(const GradientTask& task, GradientBlock& block) {
  const Conv2dShape& s = task.shape;
  const int columns = block.taps + block.bias;
  for (int k = 0; k < task.count * columns * lanes; ++k) block.acc[k] = 0;
  for_each_part(s.dst_rows, larger(1, gradient_positions / s.dst_columns), [&](int i, int i_end) {
    GradientPlace rows{};
    rows.src = task.src.data + (i * s.stride_rows - s.pad_rows) * task.src.row - s.pad_columns * lanes;
    rows.src_row = s.stride_rows * task.src.row;
    rows.src_column = static_cast<std::ptrdiff_t>(s.stride_columns) * lanes;
    rows.diff_dst = task.diff_dst.data + task.first * task.diff_dst.channel + i * task.diff_dst.row;
    rows.diff_channel = task.diff_dst.channel;
    rows.diff_row = task.diff_dst.row;
    rows.rows = i_end - i;
    rows.columns = s.dst_columns;
    rows.acc_channel = static_cast<std::ptrdiff_t>(columns) * lanes;
    for_each_part(task.count, V::tile_channels, [&](int q, int q_end) {
      for_each_part(columns, V::tile_columns, [&](int t, int t_end) {
        const GradientTile tile = find_gradient_tile<V>(q_end - q, t_end - t, t_end > block.taps);
        for (int lane = 0; lane < lanes; lane += V::width) {
          GradientPlace place = rows;
          place.src += lane;
          place.diff_dst += q * rows.diff_channel + lane;
          tile(place, block.offset + t, block.acc + q * rows.acc_channel + t * lanes + lane);
        }
      });
    });
  });
}

template <class V>
void conv2d_backward_weight(const Conv2dShape& s, View<const float> src, View<const float> diff_dst, int valid,
                            float* diff_weight, float* diff_bias, int first, int last) {
  const int kernel = s.kernel_rows * s.kernel_columns, taps = s.src_channels * kernel;
  GradientBlock block;
  for (int begin = first; begin < last; begin += gradient_channels) {
    const GradientTask task{s, src, diff_dst, begin, smaller(gradient_channels, last - begin)};
    for_each_part(taps, gradient_taps, [&](int t, int t_end) {
      block.taps = t_end - t;
      block.bias = t == 0 ? 1 : 0;
      for (int k = t; k < t_end; ++k)
        block.offset[k - t] =
            k / kernel * src.channel + k % kernel / s.kernel_columns * src.row + k % s.kernel_columns * lanes;
      accumulate_gradient<V>(task, block);
      const int columns = block.taps + block.bias;
      for (int q = 0; q < task.count; ++q) {
        lane_trees(block.acc + q * columns * lanes, columns, valid, block.result);
        float* row = diff_weight + static_cast<std::ptrdiff_t>(begin + q) * taps + t;
        for (int k = 0; k < block.taps; ++k) row[k] = block.result[k];
        if (block.bias != 0) diff_bias[begin + q] = block.result[block.taps];
      }
    });
  }
}

}  // namespace
}  // namespace decid::nn
