// Gradient of a convolution's weights: tiles of output channels x taps of accumulators, each one chain over all
// positions (i, j) in order; the lane tree comes last. Chains pause in a scratch between blocks of rows.
#pragma once

#include "nn/kernels/generic_conv.hpp"

namespace decid::nn {
namespace {

constexpr int gradient_channels = 16;
/// Taps (channel, row and column of the kernel, flat) of a block at most: 14 channels of 3 x 3. Their accumulators for
/// 16 output channels, 130 KB, stay in a 1 MB second-level cache with the rows they meet.
constexpr int gradient_taps = 126;
/// Positions after which a tile pauses: diff_dst of its channels there, and one channel of src under it, fill what V
/// says of a cache. Every tile of taps finds diff_dst there again, and nine taps share src.
template <class V>
int gradient_positions(int stride_rows, int stride_columns) {
  const int strides = stride_rows * stride_columns;
  const int bytes = lanes * static_cast<int>(sizeof(float)) * (V::gradient_channels + strides);
  return larger(1, V::gradient_bytes(strides > 1) / bytes);
}

/// Accumulators of 16 lanes, those of a tile side by side, [channel][tap]; in the first block of taps the bias counts
/// as one more tap, the last.
struct GradientBlock {
  std::ptrdiff_t offset[gradient_taps];
  float* acc;
  bool begins;  // the accumulators hold nothing yet
  int taps, bias;
  int src_first, src_channels;  // of src, that the taps read
};

/// A tile's inputs at the first of its rows, and how far they reach.
struct GradientPlace {
  const float* src;
  std::ptrdiff_t src_row, src_column;
  const float* diff_dst;
  std::ptrdiff_t diff_channel, diff_row;
  int rows, columns;
  bool first;  // the accumulators hold nothing yet
  // Fetched ahead, one line per position: the first row that the next tile meets, into the first-level cache; one of
  // the streams (fetch_stream) that the next positions need, into the second.
  const float *near, *far;
  std::ptrdiff_t far_row, far_column;
};

/// Q channels x T taps, and Q sums of only diff_dst if Bias, of V::width lanes.
template <class V, int Q, int T, bool Bias>
void gradient_tile(const GradientPlace& tile_place, const std::ptrdiff_t* offset, float* acc_memory) {
  using Float = typename V::Float;
  const GradientPlace place = tile_place;
  constexpr int columns = T + (Bias ? 1 : 0);
  Float acc[Q][columns];
  const auto at = [](auto q, auto t) { return (q * columns + t) * lanes; };
  if (place.first)
    unroll<Q>([&](auto q) { unroll<columns>([&](auto t) { acc[q][t] = V::broadcast(0); }); });
  else
    unroll<Q>([&](auto q) { unroll<columns>([&](auto t) { acc[q][t] = V::load(acc_memory + at(q, t)); }); });
  const float* tap[T + 1];
  unroll<T>([&](auto t) { tap[t] = in_register(place.src + offset[t]); });
  std::ptrdiff_t channel[Q];
  unroll<Q>([&](auto q) { channel[q] = q * place.diff_channel; });
  if constexpr (Q > 3) channel[3] = in_register(channel[3]);  // 0, 1 and 2 times one are addresses by themselves
  for (int i = 0; i < place.rows; ++i) {
    std::ptrdiff_t at_src = i * place.src_row;
    const float* diff = place.diff_dst + i * place.diff_row;
    const float* far = place.far + i * place.far_row;
    for (int j = place.columns; j > 0; --j) {
      __builtin_prefetch(place.near + at_src);
      __builtin_prefetch(far, 0, 2);
      // The fewer of both kinds stay in registers, the others pass through one register.
      Float dy[Q];
      unroll<Q>([&](auto q) { dy[q] = V::load(diff + channel[q]); });
      unroll<T>([&](auto t) {
        const Float x = V::keep(V::load(tap[t] + at_src));
        unroll<Q>([&](auto q) { acc[q][t] = V::fma(x, dy[q], acc[q][t]); });
      });
      if constexpr (Bias) unroll<Q>([&](auto q) { acc[q][T] = V::add(acc[q][T], dy[q]); });
      at_src = in_register(at_src + place.src_column);
      diff = in_register(diff + lanes);
      far = in_register(far + place.far_column);
    }
  }
  unroll<Q>([&](auto q) { unroll<columns>([&](auto t) { V::store(acc_memory + at(q, t), acc[q][t]); }); });
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

/// Inputs of a weight gradient, and its channels [first, first + count).
struct GradientTask {
  const Conv2dShape& shape;
  BlockView<const float> src, diff_dst;
  int first, count;
};

/// Rows [i, i_end) and columns [j, j_end) of dst, whole rows or a part of one, as all tiles of a block meet them.
inline GradientPlace locate(const GradientTask& task, int i, int i_end, int j, int j_end) {
  const Conv2dShape& s = task.shape;
  GradientPlace place{};
  place.src_row = s.stride_rows * task.src.row;
  place.src_column = static_cast<std::ptrdiff_t>(s.stride_columns) * lanes;
  place.src =
      task.src.data + i * place.src_row - s.pad_rows * task.src.row + j * place.src_column - s.pad_columns * lanes;
  place.diff_channel = task.diff_dst.channel;
  place.diff_row = task.diff_dst.row;
  place.diff_dst = task.diff_dst.data + task.first * place.diff_channel + i * place.diff_row + j * lanes;
  place.rows = i_end - i;
  place.columns = j_end - j;
  return place;
}

/// Streams of the positions that come after those at `place`: a channel of diff_dst each, or of a channel of src those
/// new rows and columns that leave one remainder by the strides.
inline int stream_count(const GradientTask& task, const GradientBlock& block) {
  return task.count + block.src_channels * task.shape.stride_rows * task.shape.stride_columns;
}

/// Lets `place` fetch a stream.
inline void fetch_stream(const GradientTask& task, const GradientBlock& block, bool row_ends, int stream,
                         GradientPlace& place) {
  const Conv2dShape& s = task.shape;
  if (stream < task.count) {
    place.far = place.diff_dst + stream * place.diff_channel +
                (row_ends ? place.rows * place.diff_row : static_cast<std::ptrdiff_t>(place.columns) * lanes);
    place.far_row = place.diff_row;
    place.far_column = lanes;
    return;
  }
  const int strides = s.stride_rows * s.stride_columns, channel = block.src_first + (stream - task.count) / strides;
  const int row = (stream - task.count) % strides / s.stride_columns, column = (stream - task.count) % s.stride_columns;
  place.far = place.src + channel * task.src.channel;
  // The cache already holds the values that the taps of the last positions have read.
  if (row_ends)
    place.far +=
        place.rows * place.src_row + (larger(s.kernel_rows - s.stride_rows, 0) + row) * task.src.row + column * lanes;
  else
    place.far += place.columns * place.src_column + row * task.src.row +
                 (larger(s.kernel_columns - s.stride_columns, 0) + column) * lanes;
  place.far_row = place.src_row;
  place.far_column = place.src_column;
}

/// The positions at `part` into all accumulators of a block of taps.
template <class V>
void accumulate_positions(const GradientTask& task, GradientBlock& block, const GradientPlace& part, bool row_ends) {
  const int columns = block.taps + block.bias;
  const int tiles = ceil_div(task.count, V::gradient_channels) * ceil_div(columns, V::gradient_columns);
  const int streams = stream_count(task, block);
  int turn = 0;
  for_each_part(task.count, V::gradient_channels, [&](int q, int q_end) {
    for_each_part(columns, V::gradient_columns, [&](int t, int t_end) {
      const GradientTile tile = find_gradient_tile<V>(q_end - q, t_end - t, t_end > block.taps);
      GradientPlace place = part;
      place.first = block.begins;
      fetch_stream(task, block, row_ends, turn++ * streams / tiles, place);
      place.diff_dst += q * part.diff_channel;
      place.near = place.src + block.offset[t_end < block.taps ? t_end : 0];
      float* const acc = block.acc + (q * columns + (q_end - q) * t) * lanes;
      for (int lane = 0; lane < lanes; lane += V::width) {
        tile(place, block.offset + t, acc + lane);
        place.src += V::width;
        place.diff_dst += V::width;
        place.near += V::width;
        place.far += V::width;
      }
    });
  });
}

/// All positions into the accumulators of a block of taps, in order.
template <class V>
void accumulate_gradient(const GradientTask& task, GradientBlock& block) {
  const Conv2dShape& s = task.shape;
  const int positions = gradient_positions<V>(s.stride_rows, s.stride_columns);
  for_each_part(s.dst_rows, larger(1, positions / s.dst_columns), [&](int i, int i_end) {
    for_each_part(s.dst_columns, i_end - i > 1 ? s.dst_columns : positions, [&](int j, int j_end) {
      accumulate_positions<V>(task, block, locate(task, i, i_end, j, j_end), j_end == s.dst_columns);
      block.begins = false;
    });
  });
}

/// Lists taps [t, t_end).
inline void list_taps(const GradientTask& task, int t, int t_end, GradientBlock& block) {
  const Conv2dShape& s = task.shape;
  const int kernel = s.kernel_rows * s.kernel_columns;
  block.taps = t_end - t;
  block.bias = t == 0 ? 1 : 0;
  block.src_first = t / kernel;
  block.src_channels = (t_end - 1) / kernel - block.src_first + 1;
  int channel = t / kernel, row = t % kernel / s.kernel_columns, column = t % s.kernel_columns;
  for (int k = 0; k < block.taps; ++k) {
    block.offset[k] = channel * task.src.channel + row * task.src.row + column * lanes;
    if (++column < s.kernel_columns) continue;
    column = 0;
    if (++row < s.kernel_rows) continue;
    row = 0;
    ++channel;
  }
}

/// Lane trees of all accumulators of a block whose first tap is t.
template <class V>
void store_gradient(const GradientTask& task, GradientBlock& block, int t, int taps, int valid, float* diff_weight,
                    float* diff_bias) {
  const int columns = block.taps + block.bias;
  float result[V::gradient_channels * V::gradient_columns];
  for_each_part(task.count, V::gradient_channels, [&](int q, int q_end) {
    for_each_part(columns, V::gradient_columns, [&](int k, int k_end) {
      const int width = k_end - k, weights = smaller(k_end, block.taps) - k;
      lane_trees<V>(block.acc + (q * columns + (q_end - q) * k) * lanes, (q_end - q) * width, valid, result);
      for (int r = 0; r < q_end - q; ++r) {
        const int channel = task.first + q + r;
        float* const weight = diff_weight + static_cast<std::ptrdiff_t>(channel) * taps + t + k;
        for (int w = 0; w < weights; ++w) weight[w] = result[r * width + w];
        if (weights < width) diff_bias[channel] = result[r * width + weights];
      }
    });
  });
}

template <class V>
void conv2d_backward_weight(const Conv2dShape& wanted, BlockView<const float> src, BlockView<const float> diff_dst,
                            int valid, float* diff_weight, float* diff_bias, int first, int last) {
  const Conv2dShape s = in_one_row(wanted, src, diff_dst);
  const int taps = s.src_channels * s.kernel_rows * s.kernel_columns;
  alignas(64) float acc[gradient_channels * (gradient_taps + 1) * lanes];
  GradientBlock block;
  block.acc = acc;
  for (int begin = first; begin < last; begin += gradient_channels) {
    const GradientTask task{s, src, diff_dst, begin, smaller(gradient_channels, last - begin)};
    for_each_part(taps, gradient_taps, [&](int t, int t_end) {
      list_taps(task, t, t_end, block);
      block.begins = true;
      accumulate_gradient<V>(task, block);
      store_gradient<V>(task, block, t, taps, valid, diff_weight, diff_bias);
    });
  }
}

}  // namespace
}  // namespace decid::nn
