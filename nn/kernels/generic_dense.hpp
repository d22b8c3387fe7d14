// Fully connected layers: several outputs at a time, so that each value of src is read once for all of them.
#pragma once

#include "nn/kernels/generic_lanes.hpp"

namespace decid::nn {
namespace {

/// Calls f(index of the first value, pointer to its lanes) for each row of channels [first, last).
template <class T, class F>
[[gnu::always_inline]] inline void for_each_row(Shape shape, const View<T>& v, int first, int last, const F& f) {
  for (int c = first; c < last; ++c)
    for (int i = 0; i < shape.rows; ++i)
      f(static_cast<std::ptrdiff_t>(c * shape.rows + i) * shape.columns, v.data + c * v.channel + i * v.row);
}

/// Registers for the 16 lanes of a value.
template <class V>
constexpr int parts = lanes / V::width;

/// Outputs [o, o + O) with O chains of each lane in flight.
template <class V, int O>
void dense_forward_tile(Shape shape, const View<const float>& src, const float* weight, const float* bias, float* dst) {
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
void dense_forward(Shape shape, const View<const float>& src, const float* weight, const float* bias, float* dst,
                   int outputs) {
  const std::ptrdiff_t size = shape.size();
  for (; outputs >= O; outputs -= O, weight += O * size, bias += O, dst += O * lanes)
    dense_forward_tile<V, O>(shape, src, weight, bias, dst);
  if constexpr (O > 1) dense_forward<V, O / 2>(shape, src, weight, bias, dst, outputs);
}

template <class V>
void fully_connected_forward(Shape src_shape, View<const float> src, const float* weight, const float* bias, float* dst,
                             int first, int last) {
  // 8 registers of chains hide the latency of two multiply-add units.
  dense_forward<V, larger(1, 8 / parts<V>)>(src_shape, src,
                                            weight + static_cast<std::ptrdiff_t>(first) * src_shape.size(),
                                            bias + first, dst + first * lanes, last - first);
}

/// J values of one row, each a chain over the outputs.
template <class V, int J>
[[gnu::always_inline]] inline void dense_backward_values(int outputs, std::ptrdiff_t size, const float* diff_dst,
                                                         const float* weight, float* diff_src) {
  typename V::Float acc[J][parts<V>];
  for (int j = 0; j < J; ++j)
    for (int p = 0; p < parts<V>; ++p) acc[j][p] = V::broadcast(0);
  for (int o = 0; o < outputs; ++o)
    for (int j = 0; j < J; ++j) {
      const typename V::Float w = V::broadcast(weight[o * size + j]);
      for (int p = 0; p < parts<V>; ++p) acc[j][p] = V::fma(w, V::load(diff_dst + o * lanes + p * V::width), acc[j][p]);
    }
  for (int j = 0; j < J; ++j)
    for (int p = 0; p < parts<V>; ++p) V::store(diff_src + j * lanes + p * V::width, acc[j][p]);
}

template <class V>
void fully_connected_backward_src(Shape src_shape, int outputs, const float* diff_dst, const float* weight,
                                  View<float> diff_src, int first, int last) {
  constexpr int tile = larger(1, 8 / parts<V>);
  const std::ptrdiff_t size = src_shape.size();
  for_each_row(src_shape, diff_src, first, last, [&](std::ptrdiff_t k, float* dx) {
    int j = 0;
    for (; j + tile <= src_shape.columns; j += tile)
      dense_backward_values<V, tile>(outputs, size, diff_dst, weight + k + j, dx + j * lanes);
    for (; j < src_shape.columns; ++j)
      dense_backward_values<V, 1>(outputs, size, diff_dst, weight + k + j, dx + j * lanes);
  });
}

/// Values of src that a weight gradient takes at a time.
constexpr int dense_values = 8;

/// diff_weight of one output and `count` values side by side.
template <class V>
[[gnu::always_inline]] inline void dense_gradient(const float* x, const float* dy, int count, int valid,
                                                  float* result) {
  if constexpr (V::width >= 8)
    if (count == dense_values && valid == lanes) {
      const Oct factor[2] = {load_oct<V>(dy), load_oct<V>(dy + 8)};
      lane_trees_of_eight<V>([&](int k, int half) { return load_oct<V>(x + k * lanes + 8 * half) * factor[half]; },
                             result);
      return;
    }
  alignas(64) float product[dense_values * lanes];
  for (int k = 0; k < count; ++k)
    for (int p = 0; p < lanes; p += V::width)
      V::store(product + k * lanes + p, V::mul(V::load(x + k * lanes + p), V::load(dy + p)));
  lane_trees<V>(product, count, valid, result);
}

template <class V>
void fully_connected_backward_weight(Shape src_shape, View<const float> src, const float* diff_dst, int valid,
                                     float* diff_weight, float* diff_bias, int first, int last) {
  const std::ptrdiff_t size = src_shape.size();
  for_each_row(src_shape, src, 0, src_shape.channels, [&](std::ptrdiff_t k, const float* x) {
    for (int o = first; o < last; ++o) {
      const float* const dy = diff_dst + o * lanes;
      float* const weight = diff_weight + o * size + k;
      int j = 0;
      for (; j + dense_values <= src_shape.columns; j += dense_values)
        dense_gradient<V>(x + j * lanes, dy, dense_values, valid, weight + j);
      if (j < src_shape.columns) dense_gradient<V>(x + j * lanes, dy, src_shape.columns - j, valid, weight + j);
    }
  });
  for (int o = first; o < last; ++o) {
    float sum[lanes];
    for (int l = 0; l < lanes; ++l) sum[l] = diff_dst[o * lanes + l];
    lane_trees<V>(sum, 1, valid, diff_bias + o);
  }
}

}  // namespace
}  // namespace decid::nn
