// Pools with padding. A maximum ignores it; an average counts it as zeros, as PyTorch's AvgPool2d does by default.
#include <algorithm>
#include <cstdint>
#include <type_traits>

#include "nn/layers/detail/layers.hpp"

namespace decid::nn {
namespace {

class PaddedPool final : public OperationOf<PaddedPool> {
 public:
  PaddedPool(const Pool& pool, int pad_rows, int pad_columns)
      : OperationOf(pool.src(), pool.dst()), pool_(pool), pad_rows_(pad_rows), pad_columns_(pad_columns) {}

  std::string text() const override { return pool_.text() + " pad " + Words::pair(pad_rows_, pad_columns_); }
  long long flops() const override { return pool_.flops(); }
  bool backward_reads_dst() const override { return false; }

  template <class T>
  void forward_pass(const ForwardPass<T>& pass) const {
    each_window(pass.dst.blocks(), [&](int block, int c, int i, int j) {
      const Plane<const T> src = pass.src.plane(block, c);
      T* const y = pass.dst.row(block, c, i) + j * lanes;
      if (pool_.kind == Pool::Kind::max) {
        int places[lanes];
        T best[lanes];
        largest(src, i, j, best, places);
        std::copy_n(best, lanes, y);
        return;
      }
      T sum[lanes] = {};
      each_in(i, j, [&](int row, int column) {
        const T* const x = src.data + row * src.row + column * lanes;
        for (int lane = 0; lane < lanes; ++lane) sum[lane] += x[lane];
      });
      for (int lane = 0; lane < lanes; ++lane) y[lane] = sum[lane] * factor<T>();
    });
  }

  template <class T>
  void backward_pass(const BackwardPass<T>& pass) const {
    if (pass.diff_src == nullptr) return;
    map(pass.src, *pass.diff_src, [](T) { return T(0); });
    each_window(pass.dst.blocks(), [&](int block, int c, int i, int j) {
      const T* const diff = pass.diff_dst.row(block, c, i) + j * lanes;
      const Plane<T> to = pass.diff_src->plane(block, c);
      if (pool_.kind == Pool::Kind::max) {
        int places[lanes];
        T best[lanes];
        largest(pass.src.plane(block, c), i, j, best, places);
        for (int lane = 0; lane < lanes; ++lane)
          to.data[places[lane] / to.columns * to.row + places[lane] % to.columns * lanes + lane] += diff[lane];
        return;
      }
      each_in(i, j, [&](int row, int column) {
        T* const dx = to.data + row * to.row + column * lanes;
        for (int lane = 0; lane < lanes; ++lane) dx[lane] += diff[lane] * factor<T>();
      });
    });
  }

 private:
  template <class T>
  T factor() const {
    return 1 / static_cast<T>(pool_.shape.kernel_rows * pool_.shape.kernel_columns);
  }

  /// body(block, channel, row and column of dst): windows of a plane in order.
  template <class Body>
  void each_window(int blocks, const Body& body) const {
    const PoolShape& s = pool_.shape;
    for_each_plane(blocks, s.channels, [&](int block, int c) {
      for (int i = 0; i < s.dst_rows; ++i)
        for (int j = 0; j < s.dst_columns; ++j) body(block, c, i, j);
    });
  }
  /// body(row, column) for what a window has of src.
  template <class Body>
  void each_in(int i, int j, const Body& body) const {
    const PoolShape& s = pool_.shape;
    const int top = i * s.stride_rows - pad_rows_, left = j * s.stride_columns - pad_columns_;
    for (int row = std::max(top, 0); row < std::min(top + s.kernel_rows, s.src_rows); ++row)
      for (int column = std::max(left, 0); column < std::min(left + s.kernel_columns, s.src_columns); ++column)
        body(row, column);
  }
  /// Writes each lane's first largest value of a window, or its last NaN, and its place row * columns + column.
  template <class T>
  void largest(Plane<const T> src, int i, int j, T* values, int* places) const {
    using Integer = std::conditional_t<sizeof(T) == 4, std::int32_t, std::int64_t>;
    constexpr int bytes = 16, parts = lanes * sizeof(T) / bytes, width = lanes / parts;
    // NOLINTNEXTLINE(modernize-use-using): g++ ignores the attribute there
    typedef T Values __attribute__((vector_size(bytes)));
    // NOLINTNEXTLINE(modernize-use-using)
    typedef Integer Places __attribute__((vector_size(bytes)));
    Values best[parts] = {};
    Places place[parts] = {}, is_first = Places{} - 1;  // all bits
    each_in(i, j, [&](int row, int column) {
      const T* const all = src.data + row * src.row + column * lanes;
      const Places here = Places{} + static_cast<Integer>(row * src.columns + column);
      for (int p = 0; p < parts; ++p) {
        Values x;
        __builtin_memcpy(&x, all + p * width, sizeof x);
        const Places takes = is_first | (x > best[p]) | (x != x);
        best[p] = takes ? x : best[p];
        place[p] = takes ? here : place[p];
      }
      is_first = Places{};
    });
    for (int lane = 0; lane < lanes; ++lane) {
      values[lane] = best[lane / width][lane % width];
      places[lane] = static_cast<int>(place[lane / width][lane % width]);
    }
  }

  Pool pool_;
  int pad_rows_, pad_columns_;
};

}  // namespace

OperationPointer padded_pool(const Pool& pool, int pad_rows, int pad_columns) {
  Pool padded = pool;
  PoolShape& s = padded.shape;
  s.dst_rows = (s.src_rows + 2 * pad_rows - s.kernel_rows) / s.stride_rows + 1;
  s.dst_columns = (s.src_columns + 2 * pad_columns - s.kernel_columns) / s.stride_columns + 1;
  return std::make_shared<PaddedPool>(padded, pad_rows, pad_columns);
}

}  // namespace decid::nn
