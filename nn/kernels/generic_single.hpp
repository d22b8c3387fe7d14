// Convolution of one sample, output channels in the lanes: a tile of registers of channels x columns of accumulators, a
// weight register and one broadcast value for each multiply-add chain's next link.
#pragma once

#include "nn/kernels/generic_lanes.hpp"

namespace decid::nn {
namespace {

/// B blocks of channels x W columns. Each tap loads B blocks of weights and broadcasts W values: with 2 x 12 registers
/// of AVX-512 that is 14 loads for 24 multiply-adds; with one block of two AVX2 registers x 6 columns 8 for 12.
template <class V, int B, int W>
void single_tile(const SingleConv<float>& s, const float* src, const float* weight, const float* bias, float* dst) {
  using Float = typename V::Float;
  constexpr int parts = lanes / V::width, registers = B * parts;
  const auto place = [](auto r) { return (r % parts) * V::width; };
  Float acc[registers][W];
  unroll<registers>([&](auto r) {
    const Float start = V::load(bias + (r / parts) * lanes + place(r));
    unroll<W>([&](auto w) { acc[r][w] = start; });
  });
  const std::ptrdiff_t block = static_cast<std::ptrdiff_t>(s.taps) * lanes, column = s.src_column;
  const std::ptrdiff_t* const offset = s.offset;
  for (int t = 0; t < s.taps; ++t, weight += lanes) {
    const float* x = src + offset[t];
    Float k[registers];
    unroll<registers>([&](auto r) { k[r] = V::load(weight + (r / parts) * block + place(r)); });
    unroll<W>([&](auto w) {
      const Float value = V::broadcast(x[w * column]);
      unroll<registers>([&](auto r) { acc[r][w] = V::fma(k[r], value, acc[r][w]); });
    });
  }
  unroll<registers>([&](auto r) {
    unroll<W>([&](auto w) { V::store(dst + (r / parts) * s.dst_block + w * lanes + place(r), acc[r][w]); });
  });
}

using SingleTile = void (*)(const SingleConv<float>&, const float*, const float*, const float*, float*);

template <class V, int B, int W>
SingleTile find_single_tile(int columns) {
  if constexpr (W > 1)
    if (columns < W) return find_single_tile<V, B, W - 1>(columns);
  return single_tile<V, B, W>;
}

template <class V>
void conv2d_single(const SingleConv<float>& s, int first, int last) {
  constexpr int max_blocks = V::width == lanes ? 2 : 1, max_columns = V::width == lanes ? 12 : 6;
  for_each_part(last - first, max_blocks, [&](int begin, int end) {
    const int b = first + begin;
    for (int i = 0; i < s.rows; ++i)
      for_each_part(s.columns, max_columns, [&](int j, int j_end) {
        const SingleTile tile = end - begin == max_blocks ? find_single_tile<V, max_blocks, max_columns>(j_end - j)
                                                          : find_single_tile<V, 1, max_columns>(j_end - j);
        tile(s, s.src + i * s.src_row + j * s.src_column, s.weight + static_cast<std::ptrdiff_t>(b) * s.taps * lanes,
             s.bias + b * lanes, s.dst + b * s.dst_block + i * s.dst_row + j * lanes);
      });
  });
}

}  // namespace
}  // namespace decid::nn
