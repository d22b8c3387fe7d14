// Pooling windows: what a line of an architecture says of them, and the kernels that run them.
#pragma once

#include <optional>
#include <string>

#include "nn/layer.hpp"

namespace decid::nn {

struct Pool {
  enum class Kind { average, global_average, max } kind;
  PoolShape shape;

  std::string text() const;
  Shape src() const { return {shape.channels, shape.src_rows, shape.src_columns}; }
  Shape dst() const { return {shape.channels, shape.dst_rows, shape.dst_columns}; }
  bool overlaps() const { return shape.stride_rows < shape.kernel_rows || shape.stride_columns < shape.kernel_columns; }
};

/// The pool that `words` describe, name included; nothing, and no word taken, if they describe no pool.
std::optional<Pool> parse_pool(Shape src, Words& words);

/// One call of the kernels for `shape`, which may be a part of a pool's.
template <class T>
void pool_forward(Pool::Kind kind, const PoolShape& shape, View<const T> src, View<T> dst) {
  const auto run = kind == Pool::Kind::max ? kernels<T>().max_pool_forward : kernels<T>().average_pool_forward;
  run(shape, src, dst);
}
template <class T>
void pool_backward(Pool::Kind kind, const PoolShape& shape, View<const T> src, View<const T> diff_dst,
                   View<T> diff_src) {
  if (kind == Pool::Kind::max)
    kernels<T>().max_pool_backward(shape, src, diff_dst, diff_src);
  else
    kernels<T>().average_pool_backward(shape, diff_dst, diff_src);
}

}  // namespace decid::nn
