// Fully connected layers: several outputs at a time, so that each value of src is read once for all of them.
#pragma once

#include "nn/kernels/generic_lanes.hpp"

namespace decid::nn {
namespace {

/// Calls f(index of the first value, pointer to its lanes) for each row of channels [first, last).
template <class T, class F>
[[gnu::always_inline]] inline void for_each_row(Shape shape, const BlockView<T>& v, int first, int last, const F& f) {
  for (int c = first; c < last; ++c)
    for (int i = 0; i < shape.rows; ++i)
      f(static_cast<std::ptrdiff_t>(c * shape.rows + i) * shape.columns, v.data + c * v.channel + i * v.row);
}

/// Registers for the 16 lanes of a value.
template <class V>
constexpr int parts = lanes / V::width;

/// Outputs [o, o + O) with O chains of each lane in flight.
template <class V, int O>
void dense_forward_tile(Shape shape, const BlockView<const float>& src, const float* weight, const float* bias,
                        float* dst) {
  const std::ptrdiff_t size = shape.size();
  typename V::Float acc[O][parts<V>];
  for (int o = 0; o < O; ++o)
    for (int p = 0; p < parts<V>; ++p) acc[o][p] = V::broadcast(bias[o]);
  for_each_row(shape, src, 0, shape.channels, [&](std::ptrdiff_t k, const float* x) {
    for (int j = 0; j < shape.columns; ++j, ++k, x += lanes)
      for (int o = 0; o < O; ++o) {
        const typename V::Float w = V::broadcast(weight[o * size + k]);
        for (int p = 0; p < parts<V>; ++p) acc[o][p] = V::fma(w, V::load(x + p * V::width), acc[o][p]);
      }
  });
  for (int o = 0; o < O; ++o)
    for (int p = 0; p < parts<V>; ++p) V::store(dst + o * lanes + p * V::width, acc[o][p]);
}

template <class V, int O>
void dense_forward(Shape shape, const BlockView<const float>& src, const float* weight, const float* bias, float* dst,
                   int outputs) {
  const std::ptrdiff_t size = shape.size();
  for (; outputs >= O; outputs -= O, weight += O * size, bias += O, dst += O * lanes)
    dense_forward_tile<V, O>(shape, src, weight, bias, dst);
  if constexpr (O > 1) dense_forward<V, O / 2>(shape, src, weight, bias, dst, outputs);
}

template <class V>
void fully_connected_forward(Shape src_shape, BlockView<const float> src, const float* weight, const float* bias,
                             float* dst, int first, int last) {
  // 8 registers of chains hide the latency of two multiply-add units.
  dense_forward<V, larger(1, 8 / parts<V>)>(src_shape, src,
                                            weight + static_cast<std::ptrdiff_t>(first) * src_shape.size(),
                                            bias + first, dst + first * lanes, last - first);
}

/// Neighbouring values of src, J of them, each a chain over the outputs; where they go.
template <class V, int J>
void dense_backward_values(int outputs, std::ptrdiff_t size, const float* diff_dst, const float* weight,
                           float* const* diff_src) {
  typename V::Float acc[J][parts<V>];
  for (int j = 0; j < J; ++j)
    for (int p = 0; p < parts<V>; ++p) acc[j][p] = V::broadcast(0);
  for (int o = 0; o < outputs; ++o)
    for (int j = 0; j < J; ++j) {
      const typename V::Float w = V::broadcast(weight[o * size + j]);
      for (int p = 0; p < parts<V>; ++p) acc[j][p] = V::fma(w, V::load(diff_dst + o * lanes + p * V::width), acc[j][p]);
    }
  for (int j = 0; j < J; ++j)
    for (int p = 0; p < parts<V>; ++p) V::store(diff_src[j] + p * V::width, acc[j][p]);
}

template <class V>
void fully_connected_backward_src(Shape src_shape, int outputs, const float* diff_dst, const float* weight,
                                  BlockView<float> diff_src, int first, int last) {
  constexpr int tile = larger(1, 8 / parts<V>);
  const std::ptrdiff_t size = src_shape.size();
  float* place[tile];
  int count = 0;
  weight += static_cast<std::ptrdiff_t>(first) * src_shape.rows * src_shape.columns;
  for_each_row(src_shape, diff_src, first, last, [&](std::ptrdiff_t, float* dx) {
    for (int j = 0; j < src_shape.columns; ++j) {
      place[count++] = dx + j * lanes;
      if (count < tile) continue;
      dense_backward_values<V, tile>(outputs, size, diff_dst, weight, place);
      weight += tile;
      count = 0;
    }
  });
  for (int j = 0; j < count; ++j) dense_backward_values<V, 1>(outputs, size, diff_dst, weight + j, place + j);
}

/// Values of src that a weight gradient takes at a time: with 16 samples 8 KB, read from the first-level cache for each
/// output.
constexpr int dense_values = 128;

/// A chunk of values, separated by sample: value k of sample l at [l * dense_values + k].
struct DenseChunk {
  alignas(64) float at[lanes * dense_values];
};

/// Values k, ..., k + 3 of all samples from four places; samples from `valid` on count as 0.
inline void transpose_four(const float* const place[4], int valid, float* at) {
  for (int l = 0; l < lanes; l += 4) {
    const Quad a = load_quad(place[0] + l), b = load_quad(place[1] + l), c = load_quad(place[2] + l),
               d = load_quad(place[3] + l);
    const Quad ab_low = __builtin_shufflevector(a, b, 0, 4, 1, 5), ab_high = __builtin_shufflevector(a, b, 2, 6, 3, 7);
    const Quad cd_low = __builtin_shufflevector(c, d, 0, 4, 1, 5), cd_high = __builtin_shufflevector(c, d, 2, 6, 3, 7);
    const Quad sample[4] = {
        __builtin_shufflevector(ab_low, cd_low, 0, 1, 4, 5), __builtin_shufflevector(ab_low, cd_low, 2, 3, 6, 7),
        __builtin_shufflevector(ab_high, cd_high, 0, 1, 4, 5), __builtin_shufflevector(ab_high, cd_high, 2, 3, 6, 7)};
    for (int s = 0; s < 4; ++s) {
      const Quad value = l + s < valid ? sample[s] : Quad{};
      __builtin_memcpy(at + (l + s) * dense_values, &value, sizeof value);
    }
  }
}

/// The lane tree of x[l] * dy[l] for V::width values at once: with samples apart its additions are those of whole
/// registers. From sample L on, S samples apart.
template <class V, int L, int S>
[[gnu::always_inline]] inline typename V::Float dense_tree(const float* x, const float* dy) {
  if constexpr (S == lanes)
    return V::mul(V::load(x + L * dense_values), V::broadcast(dy[L]));
  else
    return V::add(dense_tree<V, L, 2 * S>(x, dy), dense_tree<V, L + S, 2 * S>(x, dy));
}

/// diff_weight of one output for `count` values of a chunk.
template <class V>
void dense_gradient(const DenseChunk& chunk, const float* dy, int count, float* diff_weight) {
  int k = 0;
  for (; k + V::width <= count; k += V::width) V::store(diff_weight + k, dense_tree<V, 0, 1>(chunk.at + k, dy));
  if (k == count) return;
  float tail[V::width];
  V::store(tail, dense_tree<V, 0, 1>(chunk.at + k, dy));
  for (int t = 0; k + t < count; ++t) diff_weight[k + t] = tail[t];
}

template <class V>
void fully_connected_backward_weight(Shape src_shape, BlockView<const float> src, const float* diff_dst, int valid,
                                     float* diff_weight, float* diff_bias, int first, int last) {
  const std::ptrdiff_t size = src_shape.size();
  DenseChunk chunk;
  const float* place[dense_values] = {};
  std::ptrdiff_t begin = 0;
  int count = 0;
  const auto take_chunk = [&] {
    for (int k = count; k % 4 != 0; ++k) place[k] = place[count - 1];  // any; what comes of it is not stored
    for (int k = 0; k < count; k += 4) transpose_four(place + k, valid, chunk.at + k);
    for (int o = first; o < last; ++o) {
      float dy[lanes];
      for (int l = 0; l < lanes; ++l) dy[l] = l < valid ? diff_dst[o * lanes + l] : 0;
      dense_gradient<V>(chunk, dy, count, diff_weight + o * size + begin);
    }
    begin += count;
    count = 0;
  };
  for_each_row(src_shape, src, 0, src_shape.channels, [&](std::ptrdiff_t, const float* x) {
    for (int j = 0; j < src_shape.columns; ++j) {
      place[count++] = x + j * lanes;
      if (count == dense_values) take_chunk();
    }
  });
  if (count > 0) take_chunk();
  for (int o = first; o < last; ++o) {
    float sum[lanes];
    for (int l = 0; l < lanes; ++l) sum[l] = diff_dst[o * lanes + l];
    lane_trees<V>(sum, 1, valid, diff_bias + o);
  }
}

}  // namespace
}  // namespace decid::nn
