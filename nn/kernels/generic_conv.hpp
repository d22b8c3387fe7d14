// Convolution forward, and backward to its input, as one loop: a tile of output channels x columns of accumulators over
// a flat list of taps. The chain of every output may pause in dst between blocks of taps, since storing a float rounds
// nothing; the order of taps is the contract's.
#pragma once

#include "nn/kernels/generic_lanes.hpp"

namespace decid::nn {
namespace {

/// One column whose rows lie side by side is one row: then tiles, which take columns, share weights and what taps read.
/// The order of taps and of positions stays.
inline Conv2dShape in_one_row(const Conv2dShape& s, BlockView<const float> src, BlockView<const float> dst) {
  if (s.src_columns > 1 || s.kernel_columns > 1 || s.pad_columns > 0 || src.row != lanes || dst.row != lanes) return s;
  return {s.src_channels, 1, s.src_rows, s.dst_channels, 1, s.dst_rows, 1, s.kernel_rows, s.stride_columns,
          s.stride_rows,  0, s.pad_rows};
}

/// dst[q, i, j] = start[q] + sum over (channel, tap row, tap column) of weight * src at strides of the output's
/// position plus strides of the tap. Strides in values, may be negative.
struct Correlation {
  int rows, columns;  // of dst
  const float* src;   // for output (0, 0) and tap (0, 0, 0)
  std::ptrdiff_t src_row, src_column;
  float* dst;
  std::ptrdiff_t dst_channel, dst_row, dst_column;
  int channels, tap_rows, tap_columns;
  std::ptrdiff_t tap_channel, tap_row, tap_column;
  const float* weight;  // of q 0 and tap (0, 0, 0)
  std::ptrdiff_t weight_dst, weight_channel, weight_row, weight_column;
  const float* bias;  // start[q]; null for 0
};

/// Output channels that share what a block of taps brings into the first-level cache.
constexpr int group_channels = 16;

/// One block of taps, at most `max_taps` of them: where each reads, and its weights in the order tiles read them,
/// [tile][tap][channel of the tile].
template <int max_taps>
struct TapBlock {
  std::ptrdiff_t offset[max_taps];
  float weight[group_channels * max_taps];
  int taps;
};

/// The places that a tile reads and writes, except the taps.
struct TilePlace {
  const float* src;
  std::ptrdiff_t src_column;
  float* dst;
  std::ptrdiff_t dst_channel, dst_column;
  const float* next_src;  // fetched ahead: at the taps' offsets from here,
  const float* next_dst;  // and where the next tile goes
};

/// Q channels x W columns of V::width lanes. start: of each channel, or null to go on from dst.
template <class V, int Q, int W>
void correlation_tile(const TilePlace& tile_place, const std::ptrdiff_t* offset, const float* weight, int taps,
                      const float* start) {
  using Float = typename V::Float;
  const TilePlace place = tile_place;  // a copy that stores through dst cannot change
  const auto prefetch = [&](auto q) {
    const float* next = in_register(place.next_dst + q * place.dst_channel);
    unroll<W>([&](auto w) { __builtin_prefetch(next + w * place.dst_column, 1); });
  };
  Float acc[Q][W];
  unroll<Q>(prefetch);
  if (start != nullptr)
    unroll<Q>([&](auto q) { unroll<W>([&](auto w) { acc[q][w] = V::broadcast(start[q]); }); });
  else
    unroll<Q>([&](auto q) {
      const float* dst = in_register(place.dst + q * place.dst_channel);
      unroll<W>([&](auto w) { acc[q][w] = V::load(dst + w * place.dst_column); });
    });
  const float* column[W];
  unroll<W>([&](auto w) { column[w] = in_register(place.src + w * place.src_column); });
  for (int t = 0; t < taps; ++t, weight += Q) {
    const std::ptrdiff_t tap = offset[t];
    __builtin_prefetch(place.next_src + tap);
    Float x[W];
    unroll<W>([&](auto w) { x[w] = V::load(column[w] + tap); });
    unroll<Q>([&](auto q) {
      const Float k = V::broadcast(weight[q]);
      unroll<W>([&](auto w) { acc[q][w] = V::fma(k, x[w], acc[q][w]); });
    });
  }
  unroll<Q>([&](auto q) {
    float* dst = in_register(place.dst + q * place.dst_channel);
    unroll<W>([&](auto w) { V::store(dst + w * place.dst_column, acc[q][w]); });
  });
}

using CorrelationTile = void (*)(const TilePlace&, const std::ptrdiff_t*, const float*, int, const float*);

/// The tile for q channels and w columns, each up to the vector type's own.
template <class V, int Q = V::tile_channels, int W = V::tile_columns>
CorrelationTile find_correlation_tile(int q, int w) {
  if (q == Q && w == W) return correlation_tile<V, Q, W>;
  if constexpr (W > 1)
    if (w < W) return find_correlation_tile<V, Q, W - 1>(q, w);
  if constexpr (Q > 1) return find_correlation_tile<V, Q - 1, W>(q, w);
  return nullptr;
}

/// Channels of src that a block of taps covers: the values under one tile, rows and columns shared by neighbouring taps
/// counted once, fill what V says of a cache, and are read there again for each tile of the group.
template <class V>
int block_channels(const Correlation& s) {
  const auto column_step = static_cast<int>((s.src_column < 0 ? -s.src_column : s.src_column) / lanes);
  const int width = (V::tile_columns - 1) * column_step + s.tap_columns;
  const int channel_bytes = s.tap_rows * width * lanes * static_cast<int>(sizeof(float));
  return larger(1, smaller(V::block_bytes() / channel_bytes, V::block_taps / (s.tap_rows * s.tap_columns)));
}

/// Lists taps [begin, end) of channels x tap rows x tap columns and packs their weights for channels [first, first +
/// count).
template <class V>
void pack(const Correlation& s, int begin, int end, int first, int count, TapBlock<V::block_taps>& block) {
  block.taps = end - begin;
  std::ptrdiff_t from[V::block_taps];  // of each tap's weight of one channel
  const int plane = s.tap_rows * s.tap_columns;
  int channel = begin / plane, row = begin % plane / s.tap_columns, column = begin % s.tap_columns;
  for (int t = 0; t < block.taps; ++t) {
    block.offset[t] = channel * s.tap_channel + row * s.tap_row + column * s.tap_column;
    from[t] = channel * s.weight_channel + row * s.weight_row + column * s.weight_column;
    if (++column < s.tap_columns) continue;
    column = 0;
    if (++row < s.tap_rows) continue;
    row = 0;
    ++channel;
  }
  for_each_part(count, V::tile_channels, [&](int q, int q_end) {
    float* packed = block.weight + q * block.taps;
    const int width = q_end - q;
    for (int k = 0; k < width; ++k) {
      const float* weight = s.weight + (first + q + k) * s.weight_dst;
      for (int t = 0; t < block.taps; ++t) packed[t * width + k] = weight[from[t]];
    }
  });
}

/// Which tile of dst comes after the one at work.
enum class Next { channels, columns };

/// Rows of src that fit the first-level cache as a whole: then each channel's row is written in one go, 10% faster
/// where dst goes to memory (2 to 64 channels of 110 x 110). Else tiles of channels take turns on the same columns of
/// src.
inline bool row_fits_cache(const Correlation& s) {
  const std::ptrdiff_t step = s.src_column < 0 ? -s.src_column : s.src_column;
  constexpr std::ptrdiff_t bytes = 48 * 1024;
  return s.channels * s.tap_rows * s.columns * step * static_cast<std::ptrdiff_t>(sizeof(float)) <= bytes;
}

/// One block of taps into all of dst for channels [first, first + count). Fetching ahead is worth a factor of two on
/// planes larger than the second-level cache: hardware sees only short runs in many planes.
template <class V>
void correlate_block(const Correlation& s, const TapBlock<V::block_taps>& block, int first, int count,
                     const float* start) {
  const std::ptrdiff_t ahead = (s.tap_column > 0 ? 1 : 2) * (s.tap_columns - 1) * lanes;
  const auto run = [&](int i, int j, int j_end, int q, int q_end, Next next) {
    const CorrelationTile tile = find_correlation_tile<V>(q_end - q, j_end - j);
    const float* src = s.src + i * s.src_row + j * s.src_column;
    float* dst = s.dst + (first + q) * s.dst_channel + i * s.dst_row + j * s.dst_column;
    // With Next::channels each tile of channels fetches the next share of the columns to come.
    const float* next_src = src + (j_end - j) * s.src_column + ahead;
    const float* next_dst = dst + (j_end - j) * s.dst_column;
    if (next == Next::channels) {
      next_src += q / V::tile_channels * s.tap_columns * lanes;
      next_dst = q_end < count ? dst + (q_end - q) * s.dst_channel : next_dst - q * s.dst_channel;
    }
    for (int lane = 0; lane < lanes; lane += V::width) {
      const TilePlace place{src + lane,   s.src_column,    dst + lane,     s.dst_channel,
                            s.dst_column, next_src + lane, next_dst + lane};
      tile(place, block.offset, block.weight + q * block.taps, block.taps, start != nullptr ? start + q : nullptr);
    }
  };
  const bool by_rows = row_fits_cache(s);
  for (int i = 0; i < s.rows; ++i)
    if (by_rows)
      for_each_part(count, V::tile_channels, [&](int q, int q_end) {
        for_each_part(s.columns, V::tile_columns, [&](int j, int j_end) { run(i, j, j_end, q, q_end, Next::columns); });
      });
    else
      for_each_part(s.columns, V::tile_columns, [&](int j, int j_end) {
        for_each_part(count, V::tile_channels, [&](int q, int q_end) { run(i, j, j_end, q, q_end, Next::channels); });
      });
}

template <class V>
void correlate(const Correlation& s, int first_channel, int last_channel) {
  const int taps = s.channels * s.tap_rows * s.tap_columns;
  TapBlock<V::block_taps> block;
  for (int first = first_channel; first < last_channel; first += group_channels) {
    const int count = smaller(group_channels, last_channel - first);
    float start[group_channels];
    for (int q = 0; q < count; ++q) start[q] = s.bias != nullptr ? s.bias[first + q] : 0;
    if (taps == 0) {
      block.taps = 0;
      correlate_block<V>(s, block, first, count, start);
      continue;
    }
    // Whole channels, unless the taps of a single one are too many.
    const int step = smaller(V::block_taps, block_channels<V>(s) * s.tap_rows * s.tap_columns);
    for_each_part(taps, step, [&](int begin, int end) {
      pack<V>(s, begin, end, first, count, block);
      correlate_block<V>(s, block, first, count, begin == 0 ? start : nullptr);
    });
  }
}

template <class V>
void conv2d_forward(const Conv2dShape& wanted, BlockView<const float> src, const float* weight, const float* bias,
                    BlockView<float> dst, int first, int last) {
  const Conv2dShape s = in_one_row(wanted, src, dst);
  const std::ptrdiff_t kernel = static_cast<std::ptrdiff_t>(s.kernel_rows) * s.kernel_columns;
  Correlation c{};
  c.rows = s.dst_rows;
  c.columns = s.dst_columns;
  c.src = src.data - s.pad_rows * src.row - s.pad_columns * lanes;
  c.src_row = s.stride_rows * src.row;
  c.src_column = static_cast<std::ptrdiff_t>(s.stride_columns) * lanes;
  c.dst = dst.data;
  c.dst_channel = dst.channel;
  c.dst_row = dst.row;
  c.dst_column = lanes;
  c.channels = s.src_channels;
  c.tap_rows = s.kernel_rows;
  c.tap_columns = s.kernel_columns;
  c.tap_channel = src.channel;
  c.tap_row = src.row;
  c.tap_column = lanes;
  c.weight = weight;
  c.weight_dst = s.src_channels * kernel;
  c.weight_channel = kernel;
  c.weight_row = s.kernel_columns;
  c.weight_column = 1;
  c.bias = bias;
  correlate<V>(c, first, last);
}

/// In one direction, the positions y = phase, phase + stride, ... of src meet the taps first_tap, first_tap + stride,
/// ... at dst positions shift + (y - phase) / stride - tap number.
struct Phase {
  int count, first_tap, taps, shift;
};

inline Phase make_phase(int phase, int size, int kernel, int stride, int pad) {
  const int first_tap = (phase + pad) % stride;
  return {phase < size ? ceil_div(size - phase, stride) : 0, first_tap,
          first_tap < kernel ? ceil_div(kernel - first_tap, stride) : 0, (phase + pad - first_tap) / stride};
}

/// With stride s the positions of src fall into s classes a direction, each of which meets its own taps only: one
/// correlation with stride 1 over diff_dst for each class.
template <class V>
void conv2d_backward_src(const Conv2dShape& wanted, BlockView<const float> diff_dst, const float* weight,
                         BlockView<float> diff_src, int first, int last) {
  const Conv2dShape s = in_one_row(wanted, diff_src, diff_dst);
  const std::ptrdiff_t kernel = static_cast<std::ptrdiff_t>(s.kernel_rows) * s.kernel_columns;
  for (int y = 0; y < smaller(s.stride_rows, s.src_rows); ++y)
    for (int x = 0; x < smaller(s.stride_columns, s.src_columns); ++x) {
      const Phase row = make_phase(y, s.src_rows, s.kernel_rows, s.stride_rows, s.pad_rows);
      const Phase column = make_phase(x, s.src_columns, s.kernel_columns, s.stride_columns, s.pad_columns);
      Correlation c{};
      c.rows = row.count;
      c.columns = column.count;
      c.src = diff_dst.data + row.shift * diff_dst.row + static_cast<std::ptrdiff_t>(column.shift) * lanes;
      c.src_row = diff_dst.row;
      c.src_column = lanes;
      c.dst = diff_src.data + y * diff_src.row + static_cast<std::ptrdiff_t>(x) * lanes;
      c.dst_channel = diff_src.channel;
      c.dst_row = s.stride_rows * diff_src.row;
      c.dst_column = static_cast<std::ptrdiff_t>(s.stride_columns) * lanes;
      c.channels = s.dst_channels;
      c.tap_rows = row.taps;
      c.tap_columns = column.taps;
      c.tap_channel = diff_dst.channel;
      c.tap_row = -diff_dst.row;
      c.tap_column = -lanes;
      c.weight = weight + row.first_tap * s.kernel_columns + column.first_tap;
      c.weight_dst = kernel;
      c.weight_channel = s.src_channels * kernel;
      c.weight_row = static_cast<std::ptrdiff_t>(s.stride_rows) * s.kernel_columns;
      c.weight_column = s.stride_columns;
      c.bias = nullptr;
      correlate<V>(c, first, last);
    }
}

}  // namespace
}  // namespace decid::nn
