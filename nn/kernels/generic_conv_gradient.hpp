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
/// Positions after which a tile of this many channels pauses: diff_dst there, and one channel of src under it, fill
/// three quarters of a 48 KB first-level cache, where every tile of taps finds diff_dst again and nine taps share src.
constexpr int gradient_positions(int channels, int stride_rows, int stride_columns) {
  return 36 * 1024 / (lanes * static_cast<int>(sizeof(float)) * (channels + stride_rows * stride_columns));
}

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
  // Fetched ahead: the first row that the next tile meets, into the first-level cache; a row of src or
  // diff_dst that the next rows of dst will need, into the second.
  const float *near, *far;
  std::ptrdiff_t far_row;
};

/// Q channels x T taps, and Q sums of diff_dst alone if Bias, of V::width lanes.
template <class V, int Q, int T, bool Bias>
void gradient_tile(const GradientPlace& tile_place, const std::ptrdiff_t* offset, float* acc_memory) {
  using Float = typename V::Float;
  const GradientPlace place = tile_place;
  constexpr int columns = T + (Bias ? 1 : 0);
  Float acc[Q][columns];
  unroll<Q>([&](auto q) {
    unroll<columns>([&](auto t) {
      float* p = acc_memory + q * place.acc_channel + t * lanes;
      acc[q][t] = V::load(p);
      __builtin_prefetch(p + columns * lanes, 1);  // the next tile's
    });
  });
  for (int i = 0; i < place.rows; ++i) {
    const float* tap[T + 1];
    unroll<T>([&](auto t) { tap[t] = place.src + i * place.src_row + offset[t]; });
    const float* diff = place.diff_dst + i * place.diff_row;
    const std::ptrdiff_t near_row = i * place.src_row;
    const float* far = place.far + i * place.far_row;
    std::ptrdiff_t at_src = 0, at_diff = 0;
    for (int j = 0; j < place.columns; ++j, at_src += place.src_column, at_diff += lanes) {
      __builtin_prefetch(place.near + near_row + at_src);
      __builtin_prefetch(far + at_diff, 0, 2);
      // The fewer of both kinds stay in registers, the others pass through one register.
      Float dy[Q];
      unroll<Q>([&](auto q) { dy[q] = V::load(diff + at_diff + q * place.diff_channel); });
      unroll<T>([&](auto t) {
        const Float x = V::keep(V::load(tap[t] + at_src));
        unroll<Q>([&](auto q) { acc[q][t] = V::fma(x, dy[q], acc[q][t]); });
      });
      if constexpr (Bias) unroll<Q>([&](auto q) { acc[q][T] = V::add(acc[q][T], dy[q]); });
    }
  }
  unroll<Q>([&](auto q) {
    unroll<columns>([&](auto t) { V::store(acc_memory + q * place.acc_channel + t * lanes, acc[q][t]); });
  });
}

using GradientTile = void (*)(const GradientPlace&, const std::ptrdiff_t*, float*);

/// The tile for q channels and t taps, among which the bias counts if `bias`; each up to the vector type's own.
template <class V, int Q = V::gradient_channels, int T = V::gradient_columns>
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

/// Rows [i, i_end) and columns [j, j_end) of dst into all accumulators of a block of taps; whole rows, or a part of
/// one.
template <class V>
void accumulate_positions(const GradientTask& task, GradientBlock& block, int i, int i_end, int j, int j_end) {
  const Conv2dShape& s = task.shape;
  const int columns = block.taps + block.bias;
  GradientPlace part{};
  part.src_row = s.stride_rows * task.src.row;
  part.src_column = static_cast<std::ptrdiff_t>(s.stride_columns) * lanes;
  part.src = task.src.data + i * part.src_row - s.pad_rows * task.src.row + j * part.src_column - s.pad_columns * lanes;
  part.diff_channel = task.diff_dst.channel;
  part.diff_row = task.diff_dst.row;
  part.diff_dst = task.diff_dst.data + task.first * part.diff_channel + i * part.diff_row + j * lanes;
  part.rows = i_end - i;
  part.columns = j_end - j;
  part.acc_channel = static_cast<std::ptrdiff_t>(columns) * lanes;
  // From these positions to the next ones.
  const bool row_ends = j_end == s.dst_columns;
  const std::ptrdiff_t src_step =
      row_ends ? part.rows * part.src_row - j * part.src_column : part.columns * part.src_column;
  const std::ptrdiff_t diff_step = row_ends ? part.rows * part.diff_row - j * lanes : part.columns * lanes;
  for_each_part(task.count, V::gradient_channels, [&](int q, int q_end) {
    for_each_part(columns, V::gradient_columns, [&](int t, int t_end) {
      const GradientTile tile = find_gradient_tile<V>(q_end - q, t_end - t, t_end > block.taps);
      for (int lane = 0; lane < lanes; lane += V::width) {
        GradientPlace place = part;
        place.src += lane;
        place.diff_dst += q * part.diff_channel + lane;
        place.near = place.src + block.offset[t_end < block.taps ? t_end : 0];
        // The first tiles look after diff_dst, one channel each, the others after src.
        const int turn = t / V::gradient_columns;
        const bool diff_turn = turn < V::gradient_channels;
        place.far = diff_turn ? place.diff_dst + turn * part.diff_channel + diff_step : place.near + src_step;
        place.far_row = diff_turn ? part.diff_row : part.src_row;
        tile(place, block.offset + t, block.acc + q * part.acc_channel + t * lanes + lane);
      }
    });
  });
}

/// All positions into the accumulators of a block of taps, in order.
template <class V>
void accumulate_gradient(const GradientTask& task, GradientBlock& block) {
  const Conv2dShape& s = task.shape;
  const int positions = larger(1, gradient_positions(V::gradient_channels, s.stride_rows, s.stride_columns));
  for (int k = 0; k < task.count * (block.taps + block.bias) * lanes; ++k) block.acc[k] = 0;
  for_each_part(s.dst_rows, larger(1, positions / s.dst_columns), [&](int i, int i_end) {
    for_each_part(s.dst_columns, i_end - i > 1 ? s.dst_columns : positions,
                  [&](int j, int j_end) { accumulate_positions<V>(task, block, i, i_end, j, j_end); });
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
