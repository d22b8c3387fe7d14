// Pools with padding. A maximum ignores it; an average counts it as zeros, as PyTorch's AvgPool2d does by default.
#include <algorithm>

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
    each_window(pass.dst.blocks(), [&](int block, int c, int i, int j, int lane) {
      T& y = pass.dst.row(block, c, i)[j * lanes + lane];
      if (pool_.kind == Pool::Kind::max) {
        const int place = largest(pass.src, block, c, i, j, lane);
        y = pass.src.row(block, c, place / columns())[place % columns() * lanes + lane];
        return;
      }
      T sum = T(0);
      each_in(i, j, [&](int row, int column) { sum += pass.src.row(block, c, row)[column * lanes + lane]; });
      y = sum * factor<T>();
    });
  }

  template <class T>
  void backward_pass(const BackwardPass<T>& pass) const {
    if (pass.diff_src == nullptr) return;
    map(pass.src, *pass.diff_src, [](T) { return T(0); });
    each_window(pass.dst.blocks(), [&](int block, int c, int i, int j, int lane) {
      const T diff = pass.diff_dst.row(block, c, i)[j * lanes + lane];
      const auto to = [&](int row, int column) -> T& {
        return pass.diff_src->row(block, c, row)[column * lanes + lane];
      };
      if (pool_.kind == Pool::Kind::max) {
        const int place = largest(pass.src, block, c, i, j, lane);
        to(place / columns(), place % columns()) += diff;
        return;
      }
      each_in(i, j, [&](int row, int column) { to(row, column) += diff * factor<T>(); });
    });
  }

 private:
  int columns() const { return pool_.shape.src_columns; }
  template <class T>
  T factor() const {
    return 1 / static_cast<T>(pool_.shape.kernel_rows * pool_.shape.kernel_columns);
  }

  /// body(block, channel, row and column of dst, lane): windows of a plane in order.
  template <class Body>
  void each_window(int blocks, const Body& body) const {
    const PoolShape& s = pool_.shape;
    for_each_plane(blocks, s.channels, [&](int block, int c) {
      for (int i = 0; i < s.dst_rows; ++i)
        for (int j = 0; j < s.dst_columns; ++j)
          for (int lane = 0; lane < lanes; ++lane) body(block, c, i, j, lane);
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
  /// The place row * columns + column of a window's first largest value, or of its last NaN.
  template <class T>
  int largest(const TensorView<const T>& src, int block, int c, int i, int j, int lane) const {
    int place = -1;
    T best{};
    each_in(i, j, [&](int row, int column) {
      const T x = src.row(block, c, row)[column * lanes + lane];
      if (place >= 0 && !(x > best) && x == x) return;
      best = x;
      place = row * columns() + column;
    });
    return place;
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
