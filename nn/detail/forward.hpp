// Forward passes that training and inference share: a layer over a batch, its blocks and channels among threads.
// Not installed.
#pragma once

#include <algorithm>
#include <vector>

#include "nn/layers/layer.hpp"
#include "nn/tensor.hpp"
#include "nn/training/sharing.hpp"

namespace decid::nn {

template <class T>
void conv2d_forward(const Conv2dShape& shape, const TensorView<const T>& src, const std::vector<T>& weight,
                    const std::vector<T>& bias, const TensorView<T>& dst) {
  for_each_group(src.blocks(), shape.dst_channels, conv_group, [&](int block, int first, int last) {
    kernels<T>().conv2d_forward(shape, src.block(block), weight.data(), bias.data(), dst.block(block), first, last);
  });
}

/// `dense` has room for blocks x outputs x lanes values.
template <class T>
void fully_connected_forward(const TensorView<const T>& src, const std::vector<T>& weight, const std::vector<T>& bias,
                             const TensorView<T>& dst, AlignedBuffer<T>& dense) {
  for_each_group(src.blocks(), dst.shape().channels, output_group, [&](int block, int first, int last) {
    // The kernel writes its outputs side by side; the halo for a padded convolution behind this layer parts them.
    T* const outputs = dst.halo().empty() ? dst.row(block, 0, 0)
                                          : dense.data() + static_cast<std::size_t>(block) * bias.size() * lanes;
    kernels<T>().fully_connected_forward(src.shape(), src.block(block), weight.data(), bias.data(), outputs, first,
                                         last);
    if (!dst.halo().empty())
      for (int o = first; o < last; ++o) std::copy_n(outputs + o * lanes, lanes, dst.row(block, o, 0));
  });
}

/// Pools one block; `shape` may cover some of the pool's channels.
template <class T>
void pool_block_forward(Pool::Kind kind, const PoolShape& shape, BlockView<const T> src, BlockView<T> dst) {
  const auto run = kind == Pool::Kind::max ? kernels<T>().max_pool_forward : kernels<T>().average_pool_forward;
  run(shape, src, dst);
}

/// Calls body(shape of some channels, block, first channel) for every group of a pool's channels.
template <class Body>
void for_each_pool_group(const Pool& pool, int blocks, const Body& body) {
  for_each_group(blocks, pool.shape.channels, plane_group, [&](int block, int first, int last) {
    PoolShape part = pool.shape;
    part.channels = last - first;
    body(part, block, first);
  });
}

/// Returns the view of a block from a channel on.
template <class T>
BlockView<T> from_channel(BlockView<T> view, int channel) {
  view.data += channel * view.channel;
  return view;
}

template <class T>
void pool_forward(const Pool& pool, const TensorView<const T>& src, const TensorView<T>& dst) {
  for_each_pool_group(pool, src.blocks(), [&](const PoolShape& part, int block, int first) {
    pool_block_forward(pool.kind, part, from_channel(src.block(block), first), from_channel(dst.block(block), first));
  });
}

/// Computes the means, then the standard deviations, of all channels.
template <class T>
void statistics_forward(const TensorView<const T>& src, const TensorView<T>& dst) {
  const int channels = src.shape().channels;
  for_each_plane(src.blocks(), channels, [&](int block, int channel) {
    kernels<T>().statistics_pool_forward(src.plane(block, channel), static_cast<T>(StatisticsPool::epsilon),
                                         dst.row(block, channel, 0), dst.row(block, channels + channel, 0));
  });
}

template <class T>
void copy_plane(Plane<const T> from, Plane<T> to) {
  for (int i = 0; i < from.rows; ++i) std::copy_n(from.data + i * from.row, from.columns * lanes, to.data + i * to.row);
}

/// Copies a tensor into the channels of another from `first` on.
template <class T>
void copy_planes(const TensorView<const T>& from, const TensorView<T>& to, int first = 0) {
  for_each_plane(from.blocks(), from.shape().channels,
                 [&](int block, int c) { copy_plane<T>(from.plane(block, c), to.plane(block, first + c)); });
}

/// Returns the kind of pooling for the activation kernels.
inline Pooling make_pooling(const std::optional<Pool>& pool) {
  return !pool ? Pooling::none : pool->kind == Pool::Kind::max ? Pooling::max : Pooling::average;
}

}  // namespace decid::nn
