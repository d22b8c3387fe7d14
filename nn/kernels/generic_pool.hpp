// Pooling forward and backward. Windows of 2 x 2, the common case, are unrolled; others loop.
#pragma once

#include "nn/kernels/generic_lanes.hpp"

namespace decid::nn {
namespace {

/// A window's extent: fixed at compile time, or 0 x 0 to take it from the shape.
template <int Rows, int Columns>
struct Window {
  explicit Window(const PoolShape& s)
      : rows(Rows > 0 ? Rows : s.kernel_rows), columns(Columns > 0 ? Columns : s.kernel_columns) {}
  const int rows, columns;
};

/// Calls f(Window) with the fixed extent if there is one for this shape.
template <class F>
void with_window(const PoolShape& s, const F& f) {
  if (s.kernel_rows == 2 && s.kernel_columns == 2)
    f(Window<2, 2>(s));
  else
    f(Window<0, 0>(s));
}

/// Calls f(offset of the window's first value in src, offset in dst) for each window and register, in row order.
template <class V, class F>
[[gnu::always_inline]] inline void for_each_window(const PoolShape& s, std::ptrdiff_t src_channel,
                                                   std::ptrdiff_t src_row, std::ptrdiff_t dst_channel,
                                                   std::ptrdiff_t dst_row, const F& f) {
  for (int c = 0; c < s.channels; ++c)
    for (int i = 0; i < s.dst_rows; ++i)
      for (int j = 0; j < s.dst_columns; ++j)
        for (int l = 0; l < lanes; l += V::width)
          f(c * src_channel + i * s.stride_rows * src_row + j * s.stride_columns * lanes + l,
            c * dst_channel + i * dst_row + j * lanes + l);
}

/// Values of src that no window covers, or all if windows overlap and their shares add up, become 0.
template <class V>
void clear_for_windows(const PoolShape& s, const BlockView<float>& v, bool overlap) {
  // Windows tile the plane up to here if their stride equals their extent.
  const bool tiled = !overlap && s.stride_rows == s.kernel_rows && s.stride_columns == s.kernel_columns;
  const int covered_rows = tiled ? s.dst_rows * s.kernel_rows : 0;
  const int covered_columns = tiled ? s.dst_columns * s.kernel_columns : 0;
  for (int c = 0; c < s.channels; ++c)
    for (int i = 0; i < s.src_rows; ++i) {
      float* row = v.data + c * v.channel + i * v.row;
      for (int j = (i < covered_rows ? covered_columns : 0) * lanes; j < s.src_columns * lanes; j += V::width)
        V::store(row + j, V::broadcast(0));
    }
}

/// Returns true if windows share values of src. Otherwise each value belongs to at most one window, and its gradient is
/// written once and not added up.
inline bool windows_overlap(const PoolShape& s) {
  return (s.stride_rows < s.kernel_rows && s.dst_rows > 1) ||
         (s.stride_columns < s.kernel_columns && s.dst_columns > 1);
}

template <class V>
void average_pool_forward(const PoolShape& s, BlockView<const float> src, BlockView<float> dst) {
  using Float = typename V::Float;
  const Float factor = V::broadcast(1 / static_cast<float>(s.kernel_rows * s.kernel_columns));
  with_window(s, [&](const auto& window) {
    for_each_window<V>(s, src.channel, src.row, dst.channel, dst.row, [&](std::ptrdiff_t from, std::ptrdiff_t to) {
      Float acc = V::broadcast(0);
      for (int ky = 0; ky < window.rows; ++ky)
        for (int kx = 0; kx < window.columns; ++kx)
          acc = V::add(acc, V::load(src.data + from + ky * src.row + kx * lanes));
      V::store(dst.data + to, V::mul(acc, factor));
    });
  });
}

template <class V>
void average_pool_backward(const PoolShape& s, BlockView<const float> diff_dst, BlockView<float> diff_src) {
  using Float = typename V::Float;
  const Float zero = V::broadcast(0), factor = V::broadcast(1 / static_cast<float>(s.kernel_rows * s.kernel_columns));
  const bool overlap = windows_overlap(s);
  clear_for_windows<V>(s, diff_src, overlap);
  with_window(s, [&](const auto& window) {
    for_each_window<V>(s, diff_src.channel, diff_src.row, diff_dst.channel, diff_dst.row,
                       [&](std::ptrdiff_t to, std::ptrdiff_t from) {
                         const Float share = V::mul(V::load(diff_dst.data + from), factor);
                         for (int ky = 0; ky < window.rows; ++ky)
                           for (int kx = 0; kx < window.columns; ++kx) {
                             float* p = diff_src.data + to + ky * diff_src.row + kx * lanes;
                             // 0 + share even where nothing else is added: it turns -0 into +0.
                             V::store(p, V::add(overlap ? V::load(p) : zero, share));
                           }
                       });
  });
}

template <class V>
void max_pool_forward(const PoolShape& s, BlockView<const float> src, BlockView<float> dst) {
  using Float = typename V::Float;
  with_window(s, [&](const auto& window) {
    for_each_window<V>(s, src.channel, src.row, dst.channel, dst.row, [&](std::ptrdiff_t from, std::ptrdiff_t to) {
      Float best = V::load(src.data + from);
      for (int ky = 0; ky < window.rows; ++ky)
        for (int kx = 0; kx < window.columns; ++kx) {
          const Float x = V::load(src.data + from + ky * src.row + kx * lanes);
          best = V::if_greater_or_nan(x, best, x, best);
        }
      V::store(dst.data + to, best);
    });
  });
}

template <class V>
void max_pool_backward(const PoolShape& s, BlockView<const float> src, BlockView<const float> diff_dst,
                       BlockView<float> diff_src) {
  using Float = typename V::Float;
  const Float zero = V::broadcast(0);
  const bool overlap = windows_overlap(s);
  clear_for_windows<V>(s, diff_src, overlap);
  // diff_src may have another halo than src, so its windows are located again from diff_dst's position.
  with_window(s, [&](const auto& window) {
    for (int c = 0; c < s.channels; ++c)
      for (int i = 0; i < s.dst_rows; ++i)
        for (int j = 0; j < s.dst_columns; ++j)
          for (int l = 0; l < lanes; l += V::width) {
            const std::ptrdiff_t column = static_cast<std::ptrdiff_t>(j) * s.stride_columns * lanes + l;
            const float* from = src.data + c * src.channel + i * s.stride_rows * src.row + column;
            float* to = diff_src.data + c * diff_src.channel + i * s.stride_rows * diff_src.row + column;
            const Float dy = V::load(diff_dst.data + c * diff_dst.channel + i * diff_dst.row + j * lanes + l);
            // The number of the first largest value, or of the last NaN, counted in float: exact up to 2^24 values.
            Float best = V::load(from), best_at = zero;
            for (int ky = 0; ky < window.rows; ++ky)
              for (int kx = 0; kx < window.columns; ++kx) {
                const Float x = V::load(from + ky * src.row + kx * lanes);
                const Float at = V::broadcast(static_cast<float>(ky * window.columns + kx));
                best_at = V::if_greater_or_nan(x, best, at, best_at);
                best = V::if_greater_or_nan(x, best, x, best);
              }
            for (int ky = 0; ky < window.rows; ++ky)
              for (int kx = 0; kx < window.columns; ++kx) {
                float* p = to + ky * diff_src.row + kx * lanes;
                const Float at = V::broadcast(static_cast<float>(ky * window.columns + kx));
                // Equal if neither is greater.
                const Float share = V::if_greater(at, best_at, zero, V::if_greater(best_at, at, zero, dy));
                V::store(p, V::add(overlap ? V::load(p) : zero, share));
              }
          }
  });
}

}  // namespace
}  // namespace decid::nn
