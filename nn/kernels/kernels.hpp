// The engine's arithmetic: one table of kernels per instruction set, all with the same bits.
//
// The contract of bits. Every value is one chain of fused multiply-adds, acc = fma(a, b, acc), in the order given at
// each kernel; a chain never depends on the vector width, the tile, the thread or the batch around a sample.
// Reductions over the batch sum the 16 lanes of a block by the tree l + (l + 8), + 4, + 2, + 1, lanes without a
// sample counting as 0, and the blocks by tree_sum. Nothing else is summed across lanes. The program's version changes
// the bits. Threads, instruction set, compiler, and the samples that share a batch in inference do not change them.
//
// A kernel works on one block of 16 samples (or on plain arrays) and runs in one thread; layers distribute the blocks.
// A BlockView starts at that block. T is float, or double in the gradient checks.
#pragma once

#include <cstddef>

#include "base/isa.hpp"
#include "nn/tensor.hpp"

namespace decid::nn {

/// A convolution's geometry: dst = floor((src + 2 pad - kernel) / stride) + 1 in each direction.
struct Conv2dShape {
  int src_channels, src_rows, src_columns;
  int dst_channels, dst_rows, dst_columns;
  int kernel_rows, kernel_columns;
  int stride_rows, stride_columns;
  int pad_rows, pad_columns;
};

/// Returns `rows` rows of dst as a separate convolution. Its src begins at the first row that they meet, row
/// stride_rows - pad_rows, in the halo above the plane at first.
inline Conv2dShape make_band(Conv2dShape s, int rows) {
  s.dst_rows = rows;
  s.src_rows = (rows - 1) * s.stride_rows + s.kernel_rows;
  s.pad_rows = 0;
  return s;
}

/// Pooling windows: dst = floor((src - kernel) / stride) + 1, no padding.
struct PoolShape {
  int channels, src_rows, src_columns, dst_rows, dst_columns;
  int kernel_rows, kernel_columns, stride_rows, stride_columns;
};

/// The activation after a normalisation: scale, shift, optional ReLU, and a pool whose windows do not overlap.
enum class Pooling { none, average, max };
template <class T>
struct Activation {
  T scale, shift;
  bool relu;
  Pooling pooling;
};

/// tanh, 1 / (1 + exp(-x)), and GELU, x Phi(x). Hendrycks and Gimpel, "Gaussian error linear units", 2016.
enum class Sigmoid { tanh, logistic, gelu };

/// A convolution of one sample, output channels in the lanes: blocks of 16 channels, [block][row][column][lane]. A
/// fully connected layer is one whose only position sees all values.
template <class T>
struct SingleConv {
  int rows, columns;                   ///< of dst
  const T* src;                        ///< value that tap offset 0 reads for position (0, 0)
  std::ptrdiff_t src_row, src_column;  ///< from one position of dst to the next
  const std::ptrdiff_t* offset;        ///< of each tap, in the order of the chain
  int taps;
  const T* weight;  ///< [block][tap][lane]
  const T* bias;    ///< [block][lane]
  T* dst;
  std::ptrdiff_t dst_block, dst_row;
};

template <class T>
struct Kernels {
  const char* name;

  /// dst[o,i,j] = bias[o] + sum over (c, ky, kx), in that order, of weight[o,c,ky,kx] * src[c, i s + ky - p, j s + kx -
  /// p]. Padding counts as terms with value +0. src has a halo of at least the padding. For o in [first, last).
  void (*conv2d_forward)(const Conv2dShape&, BlockView<const T> src, const T* weight, const T* bias, BlockView<T> dst,
                         int first, int last);
  /// diff_src[c,y,x] = 0 + sum over (o, ky, kx), in that order, of weight[o,c,ky,kx] * diff_dst[o, (y+p-ky)/s,
  /// (x+p-kx)/s]; only taps for which s divides; outside the plane diff_dst counts as +0 and is read from its halo
  /// (diff_halo(shape)). For c in [first, last).
  void (*conv2d_backward_src)(const Conv2dShape&, BlockView<const T> diff_dst, const T* weight, BlockView<T> diff_src,
                              int first, int last);
  /// diff_weight[o,c,ky,kx] = lane tree of: sum over (i, j) of src[c, i s + ky - p, j s + kx - p] * diff_dst[o,i,j];
  /// diff_bias[o] = lane tree of: sum over (i, j) of diff_dst[o,i,j]. Lanes from `valid` on count as 0.
  /// For o in [first, last); the arrays are whole.
  void (*conv2d_backward_weight)(const Conv2dShape&, BlockView<const T> src, BlockView<const T> diff_dst, int valid,
                                 T* diff_weight, T* diff_bias, int first, int last);

  /// dst[o] = bias[o] + sum over k of weight[o,k] * src[k]; k runs over (channel, row, column). dst: outputs x lanes.
  void (*fully_connected_forward)(Shape src_shape, BlockView<const T> src, const T* weight, const T* bias, T* dst,
                                  int first, int last);
  /// diff_src[k] = 0 + sum over o of weight[o,k] * diff_dst[o]. For channels in [first, last).
  void (*fully_connected_backward_src)(Shape src_shape, int outputs, const T* diff_dst, const T* weight,
                                       BlockView<T> diff_src, int first, int last);
  /// diff_weight[o,k] = lane tree of src[k] * diff_dst[o]; diff_bias[o] = lane tree of diff_dst[o].
  void (*fully_connected_backward_weight)(Shape src_shape, BlockView<const T> src, const T* diff_dst, int valid,
                                          T* diff_weight, T* diff_bias, int first, int last);

  /// dst[o,i,j] = bias[o] + sum over taps t, in order, of weight[o,t] * src[i row + j column + offset[t]]: with the
  /// taps in order (c, ky, kx) the bits of conv2d_forward for that sample. For blocks of output channels in [first,
  /// last).
  void (*conv2d_single)(const SingleConv<T>&, int first, int last);

  /// With d = src - pivot: sums[l] += each row's chain of d + ... of lane l, in double, row after row;
  /// sums[lanes + l] += the same of d * d. Calls for parts of a plane, in order of rows, add up to one for the whole.
  void (*batchnorm_sums)(Plane<const T> src, T pivot, double sums[2 * lanes]);
  /// As above the sums of diff_dst and of diff_dst * (src - mean).
  void (*batchnorm_backward_sums)(Plane<const T> src, Plane<const T> diff_dst, T mean, double sums[2 * lanes]);
  /// diff_src = fma(a, diff_dst, fma(b, src, c)); may overwrite src or diff_dst.
  void (*batchnorm_backward_apply)(Plane<const T> src, Plane<const T> diff_dst, T a, T b, T c, Plane<T> diff_src);

  /// dst = pool(relu(fma(src, scale, shift))) of one channel; ReLU and pool as their kernels below. Without a pool the
  /// shape is not read.
  void (*activation_forward)(const Activation<T>&, const PoolShape&, Plane<const T> src, Plane<T> dst);
  /// diff = the derivative by the value of that fma, of the same kernels' backward. Without a pool diff may be
  /// diff_dst.
  void (*activation_backward)(const Activation<T>&, const PoolShape&, Plane<const T> src, Plane<const T> diff_dst,
                              Plane<T> diff);

  /// value = value < 0 ? 0 : value, in place.
  void (*relu_forward)(Plane<T> value);
  /// diff = value > 0 ? diff : 0, in place; value is the layer's output.
  void (*relu_backward)(Plane<const T> value, Plane<T> diff);

  /// dst = (chain of additions over the window, row by row) * (1 / window size). All channels of the block.
  void (*average_pool_forward)(const PoolShape&, BlockView<const T> src, BlockView<T> dst);
  /// diff_src: zero, then every window in row order adds diff_dst * (1 / window size) to each of its values.
  void (*average_pool_backward)(const PoolShape&, BlockView<const T> diff_dst, BlockView<T> diff_src);
  /// dst: the window's largest value, NaN if any is one.
  void (*max_pool_forward)(const PoolShape&, BlockView<const T> src, BlockView<T> dst);
  /// diff_src: zero, then every window in row order adds its diff_dst to its first largest value, or to its last NaN.
  void (*max_pool_backward)(const PoolShape&, BlockView<const T> src, BlockView<const T> diff_dst,
                            BlockView<T> diff_src);

  /// For each lane: mean = (chain of additions over the plane, row by row) * (1 / its values); stddev = the square
  /// root of fma(chain of squares of value - mean, 1 / its values, epsilon).
  void (*statistics_pool_forward)(Plane<const T> src, T epsilon, T* mean, T* stddev);
  /// diff_src = fma(diff_stddev * (1 / values) / stddev, src - mean, diff_mean * (1 / values)).
  void (*statistics_pool_backward)(Plane<const T> src, const T* mean, const T* stddev, const T* diff_mean,
                                   const T* diff_stddev, Plane<T> diff_src);

  /// gradient' = fma(weight_decay, value, gradient); velocity = fma(momentum, velocity, gradient');
  /// value = fma(-learning_rate, velocity, value).
  void (*sgd_step)(std::size_t count, T learning_rate, T momentum, T weight_decay, const T* gradient, T* velocity,
                   T* value);

  /// dst = the function of src, in double with base/math/math.hpp, then rounded.
  void (*sigmoid_forward)(Sigmoid, Plane<const T> src, Plane<T> dst);
  /// diff_src = diff_dst * (Phi(x) + x Phi'(x)), x = src; the factor in double, then rounded.
  void (*gelu_backward)(Plane<const T> src, Plane<const T> diff_dst, Plane<T> diff_src);
};

/// Returns the plain definitions, which are easy to read and test the other kernels.
template <class T>
const Kernels<T>& reference_kernels();

/// Returns the kernels in use: for float those of chosen_isa(), see base/isa.hpp; for double the reference.
template <class T>
const Kernels<T>& kernels();
/// Returns the kernels of an available instruction set.
const Kernels<float>& kernels_for(Isa isa);

/// Returns the halo that conv2d_forward reads around src: the padding.
Halo src_halo(const Conv2dShape& shape);
/// Returns the halo that conv2d_backward_src reads around diff_dst.
Halo diff_halo(const Conv2dShape& shape);

/// Returns the sum over the lanes of a block, by the contract's tree; lanes from `valid` on count as 0.
template <class T>
T lane_sum(const T* value, int valid) {
  T v[lanes];
  for (int l = 0; l < lanes; ++l) v[l] = l < valid ? value[l] : T(0);
  for (int half = lanes / 2; half > 0; half /= 2)
    for (int l = 0; l < half; ++l) v[l] += v[l + half];
  return v[0];
}

/// Adds `count` parts, `stride` values apart, into the first, `size` values each: part i + part i + n/2 for the
/// smallest power of two n >= count, then n/4, ... The tree has a fixed shape that depends only on count.
template <class T>
void tree_sum(T* parts, int count, std::size_t stride, std::size_t size) {
  int half = 1;
  while (half < count) half *= 2;
  for (half /= 2; half > 0; half /= 2)
    for (int i = 0; i < half && i + half < count; ++i) {
      T* const to = parts + static_cast<std::size_t>(i) * stride;
      const T* const from = parts + static_cast<std::size_t>(i + half) * stride;
      for (std::size_t k = 0; k < size; ++k) to[k] += from[k];
    }
}

}  // namespace decid::nn
