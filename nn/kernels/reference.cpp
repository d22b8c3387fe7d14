// The plain definitions of every kernel, one loop a sum: what the fast ones are tested against, and what gradient
// checks run in double. The order of each chain is the contract written in kernels.hpp.
#include <algorithm>
#include <cmath>

#include "base/math/math.hpp"
#include "nn/kernels/kernels.hpp"

namespace decid::nn {
namespace {

/// Lane l at (channel, row, column), +0 outside the plane.
template <class T>
T value_or_zero(BlockView<const T> v, int rows, int columns, int channel, int row, int column, int lane) {
  if (row < 0 || row >= rows || column < 0 || column >= columns) return T(0);
  return v.data[channel * v.channel + row * v.row + column * lanes + lane];
}

std::size_t weight_index(const Conv2dShape& s, int o, int c, int ky, int kx) {
  const int index = ((o * s.src_channels + c) * s.kernel_rows + ky) * s.kernel_columns + kx;
  return static_cast<std::size_t>(index);
}

template <class T>
void conv2d_forward(const Conv2dShape& s, BlockView<const T> src, const T* weight, const T* bias, BlockView<T> dst,
                    int first, int last) {
  for (int o = first; o < last; ++o)
    for (int i = 0; i < s.dst_rows; ++i)
      for (int j = 0; j < s.dst_columns; ++j)
        for (int l = 0; l < lanes; ++l) {
          T acc = bias[o];
          for (int c = 0; c < s.src_channels; ++c)
            for (int ky = 0; ky < s.kernel_rows; ++ky)
              for (int kx = 0; kx < s.kernel_columns; ++kx)
                acc = std::fma(weight[weight_index(s, o, c, ky, kx)],
                               value_or_zero(src, s.src_rows, s.src_columns, c, i * s.stride_rows + ky - s.pad_rows,
                                             j * s.stride_columns + kx - s.pad_columns, l),
                               acc);
          dst.data[o * dst.channel + i * dst.row + j * lanes + l] = acc;
        }
}

template <class T>
void conv2d_backward_src(const Conv2dShape& s, BlockView<const T> diff_dst, const T* weight, BlockView<T> diff_src,
                         int first, int last) {
  // floor((position - tap) / stride): positions left of the plane are negative and must not round to 0.
  const auto floor_div = [](int a, int b) { return a >= 0 ? a / b : -((b - 1 - a) / b); };
  for (int c = first; c < last; ++c)
    for (int y = 0; y < s.src_rows; ++y)
      for (int x = 0; x < s.src_columns; ++x)
        for (int l = 0; l < lanes; ++l) {
          T acc = T(0);
          for (int o = 0; o < s.dst_channels; ++o)
            for (int ky = 0; ky < s.kernel_rows; ++ky)
              for (int kx = 0; kx < s.kernel_columns; ++kx) {
                const int iy = y + s.pad_rows - ky, jx = x + s.pad_columns - kx;
                if (iy % s.stride_rows != 0 || jx % s.stride_columns != 0) continue;
                acc = std::fma(weight[weight_index(s, o, c, ky, kx)],
                               value_or_zero(diff_dst, s.dst_rows, s.dst_columns, o, floor_div(iy, s.stride_rows),
                                             floor_div(jx, s.stride_columns), l),
                               acc);
              }
          diff_src.data[c * diff_src.channel + y * diff_src.row + x * lanes + l] = acc;
        }
}

/// Continues the chain of each lane: of the weight at (c, ky, kx), or, past the last channel, of the bias.
template <class T>
void continue_chain(const Conv2dShape& s, BlockView<const T> src, const T* diff_dst, std::ptrdiff_t diff_row, int c,
                    int ky, int kx, T* chain) {
  for (int l = 0; l < lanes; ++l)
    for (int i = 0; i < s.dst_rows; ++i)
      for (int j = 0; j < s.dst_columns; ++j) {
        const T dy = diff_dst[i * diff_row + j * lanes + l];
        chain[l] = c == s.src_channels
                       ? chain[l] + dy
                       : std::fma(value_or_zero(src, s.src_rows, s.src_columns, c, i * s.stride_rows + ky - s.pad_rows,
                                                j * s.stride_columns + kx - s.pad_columns, l),
                                  dy, chain[l]);
      }
}

/// Calls f(c, ky, kx) for each weight of one channel of dst in order, then for its bias, at c = src_channels.
template <class F>
void for_each_gradient(const Conv2dShape& s, const F& f) {
  for (int c = 0; c < s.src_channels; ++c)
    for (int ky = 0; ky < s.kernel_rows; ++ky)
      for (int kx = 0; kx < s.kernel_columns; ++kx) f(c, ky, kx);
  f(s.src_channels, 0, 0);
}

template <class T>
void conv2d_backward_weight(const Conv2dShape& s, BlockView<const T> src, BlockView<const T> diff_dst, int valid,
                            T* diff_weight, T* diff_bias, int first, int last) {
  for (int o = first; o < last; ++o)
    for_each_gradient(s, [&](int c, int ky, int kx) {
      T chain[lanes] = {};
      continue_chain(s, src, diff_dst.data + o * diff_dst.channel, diff_dst.row, c, ky, kx, chain);
      (c == s.src_channels ? diff_bias[o] : diff_weight[weight_index(s, o, c, ky, kx)]) = lane_sum(chain, valid);
    });
}

/// Calls f(k, pointer to the lanes of value k) in the order of weights: channel, row, column.
template <class T, class F>
void for_each_value(Shape shape, BlockView<T> v, int first, int last, const F& f) {
  for (int c = first; c < last; ++c)
    for (int i = 0; i < shape.rows; ++i)
      for (int j = 0; j < shape.columns; ++j)
        f(static_cast<std::size_t>(c * shape.rows + i) * static_cast<std::size_t>(shape.columns) +
              static_cast<std::size_t>(j),
          v.data + c * v.channel + i * v.row + j * lanes);
}

template <class T>
void fully_connected_forward(Shape shape, BlockView<const T> src, const T* weight, const T* bias, T* dst, int first,
                             int last) {
  for (int o = first; o < last; ++o) {
    T* acc = dst + o * lanes;
    const T* w = weight + static_cast<std::size_t>(o) * static_cast<std::size_t>(shape.size());
    for (int l = 0; l < lanes; ++l) acc[l] = bias[o];
    for_each_value(shape, src, 0, shape.channels, [&](std::size_t k, const T* x) {
      for (int l = 0; l < lanes; ++l) acc[l] = std::fma(w[k], x[l], acc[l]);
    });
  }
}

template <class T>
void fully_connected_backward_src(Shape shape, int outputs, const T* diff_dst, const T* weight, BlockView<T> diff_src,
                                  int first, int last) {
  for_each_value(shape, diff_src, first, last, [&](std::size_t k, T* dx) {
    for (int l = 0; l < lanes; ++l) {
      T acc = T(0);
      for (int o = 0; o < outputs; ++o)
        acc = std::fma(weight[static_cast<std::size_t>(o) * static_cast<std::size_t>(shape.size()) + k],
                       diff_dst[o * lanes + l], acc);
      dx[l] = acc;
    }
  });
}

template <class T>
void fully_connected_backward_weight(Shape shape, BlockView<const T> src, const T* diff_dst, int valid, T* diff_weight,
                                     T* diff_bias, int first, int last) {
  for (int o = first; o < last; ++o) {
    const T* dy = diff_dst + o * lanes;
    T* dw = diff_weight + static_cast<std::size_t>(o) * static_cast<std::size_t>(shape.size());
    for_each_value(shape, src, 0, shape.channels, [&](std::size_t k, const T* x) {
      T product[lanes];
      for (int l = 0; l < lanes; ++l) product[l] = x[l] * dy[l];
      dw[k] = lane_sum(product, valid);
    });
    diff_bias[o] = lane_sum(dy, valid);
  }
}

template <class T>
void conv2d_single(const SingleConv<T>& s, int first, int last) {
  for (int block = first; block < last; ++block)
    for (int i = 0; i < s.rows; ++i)
      for (int j = 0; j < s.columns; ++j)
        for (int l = 0; l < lanes; ++l) {
          const T* weight = s.weight + static_cast<std::ptrdiff_t>(block) * s.taps * lanes;
          T acc = s.bias[block * lanes + l];
          for (int t = 0; t < s.taps; ++t)
            acc = std::fma(weight[t * lanes + l], s.src[i * s.src_row + j * s.src_column + s.offset[t]], acc);
          s.dst[block * s.dst_block + i * s.dst_row + j * lanes + l] = acc;
        }
}

/// Adds to sums the rows' chains of each lane; f(row, column, lane, acc) continues a chain.
template <class T, class F>
void add_row_chains(int rows, int columns, double* sums, const F& f) {
  for (int i = 0; i < rows; ++i)
    for (int l = 0; l < lanes; ++l) {
      T acc = T(0);
      for (int j = 0; j < columns; ++j) acc = f(i, j, l, acc);
      sums[l] += static_cast<double>(acc);
    }
}

template <class T>
T get(const Plane<T>& p, int i, int j, int l) {
  return p.data[i * p.row + j * lanes + l];
}

template <class T>
void batchnorm_sums(Plane<const T> src, T pivot, double sums[2 * lanes]) {
  add_row_chains<T>(src.rows, src.columns, sums,
                    [&](int i, int j, int l, T acc) { return acc + (get(src, i, j, l) - pivot); });
  add_row_chains<T>(src.rows, src.columns, sums + lanes, [&](int i, int j, int l, T acc) {
    const T d = get(src, i, j, l) - pivot;
    return std::fma(d, d, acc);
  });
}

template <class T>
void batchnorm_backward_sums(Plane<const T> src, Plane<const T> diff_dst, T mean, double sums[2 * lanes]) {
  add_row_chains<T>(src.rows, src.columns, sums,
                    [&](int i, int j, int l, T acc) { return acc + get(diff_dst, i, j, l); });
  add_row_chains<T>(src.rows, src.columns, sums + lanes, [&](int i, int j, int l, T acc) {
    return std::fma(get(diff_dst, i, j, l), get(src, i, j, l) - mean, acc);
  });
}

/// Calls f(value index within the rows of a, b and c) for every value of a plane.
template <class T, class F>
void for_each_row_value(const Plane<T>& plane, const F& f) {
  for (int i = 0; i < plane.rows; ++i)
    for (int j = 0; j < plane.columns * lanes; ++j) f(i, j);
}

template <class T>
void batchnorm_backward_apply(Plane<const T> src, Plane<const T> diff_dst, T a, T b, T c, Plane<T> diff_src) {
  for_each_row_value(src, [&](int i, int j) {
    diff_src.data[i * diff_src.row + j] =
        std::fma(a, diff_dst.data[i * diff_dst.row + j], std::fma(b, src.data[i * src.row + j], c));
  });
}

template <class T>
void relu_forward(Plane<T> value) {
  for_each_row_value(value, [&](int i, int j) {
    T& v = value.data[i * value.row + j];
    v = v < T(0) ? T(0) : v;
  });
}

template <class T>
void relu_backward(Plane<const T> value, Plane<T> diff) {
  for_each_row_value(value, [&](int i, int j) {
    T& d = diff.data[i * diff.row + j];
    d = value.data[i * value.row + j] > T(0) ? d : T(0);
  });
}

/// Calls f(channel, i, j, lane) for every output, windows in row order.
template <class F>
void for_each_window(const PoolShape& s, const F& f) {
  for (int c = 0; c < s.channels; ++c)
    for (int i = 0; i < s.dst_rows; ++i)
      for (int j = 0; j < s.dst_columns; ++j)
        for (int l = 0; l < lanes; ++l) f(c, i, j, l);
}

template <class T>
T& at(const BlockView<T>& v, int c, int i, int j, int l) {
  return v.data[c * v.channel + i * v.row + j * lanes + l];
}

template <class T>
void clear(const PoolShape& s, BlockView<T> v) {
  for (int c = 0; c < s.channels; ++c)
    for (int i = 0; i < s.src_rows; ++i)
      for (int j = 0; j < s.src_columns * lanes; ++j) v.data[c * v.channel + i * v.row + j] = T(0);
}

template <class T>
void average_pool_forward(const PoolShape& s, BlockView<const T> src, BlockView<T> dst) {
  const T factor = T(1) / static_cast<T>(s.kernel_rows * s.kernel_columns);
  for_each_window(s, [&](int c, int i, int j, int l) {
    T acc = T(0);
    for (int ky = 0; ky < s.kernel_rows; ++ky)
      for (int kx = 0; kx < s.kernel_columns; ++kx)
        acc += at(src, c, i * s.stride_rows + ky, j * s.stride_columns + kx, l);
    at(dst, c, i, j, l) = acc * factor;
  });
}

template <class T>
void average_pool_backward(const PoolShape& s, BlockView<const T> diff_dst, BlockView<T> diff_src) {
  const T factor = T(1) / static_cast<T>(s.kernel_rows * s.kernel_columns);
  clear(s, diff_src);
  for_each_window(s, [&](int c, int i, int j, int l) {
    const T share = at(diff_dst, c, i, j, l) * factor;
    for (int ky = 0; ky < s.kernel_rows; ++ky)
      for (int kx = 0; kx < s.kernel_columns; ++kx)
        at(diff_src, c, i * s.stride_rows + ky, j * s.stride_columns + kx, l) += share;
  });
}

/// Returns true if a pool takes x instead of the largest so far: a NaN stays, so that a diverged training shows.
template <class T>
bool is_larger(T x, T best) {
  return x > best || std::isnan(x);
}

/// Offset in values of the first largest value of a window, or of its last NaN, from the window's first value.
template <class T>
std::ptrdiff_t first_largest(const PoolShape& s, BlockView<const T> src, const T* window) {
  std::ptrdiff_t best = 0;
  for (int ky = 0; ky < s.kernel_rows; ++ky)
    for (int kx = 0; kx < s.kernel_columns; ++kx) {
      const std::ptrdiff_t offset = ky * src.row + kx * lanes;
      if (is_larger(window[offset], window[best])) best = offset;
    }
  return best;
}

template <class T>
void max_pool_forward(const PoolShape& s, BlockView<const T> src, BlockView<T> dst) {
  for_each_window(s, [&](int c, int i, int j, int l) {
    const T* window = &at(src, c, i * s.stride_rows, j * s.stride_columns, l);
    at(dst, c, i, j, l) = window[first_largest(s, src, window)];
  });
}

template <class T>
void max_pool_backward(const PoolShape& s, BlockView<const T> src, BlockView<const T> diff_dst, BlockView<T> diff_src) {
  clear(s, diff_src);
  for_each_window(s, [&](int c, int i, int j, int l) {
    const T* window = &at(src, c, i * s.stride_rows, j * s.stride_columns, l);
    const std::ptrdiff_t offset = first_largest(s, src, window);
    const std::ptrdiff_t ky = offset / src.row, kx = offset % src.row / lanes;
    at(diff_src, c, i * s.stride_rows + static_cast<int>(ky), j * s.stride_columns + static_cast<int>(kx), l) +=
        at(diff_dst, c, i, j, l);
  });
}

/// relu(fma(x, scale, shift)), or without ReLU.
template <class T>
T activate(const Activation<T>& a, T x) {
  const T y = std::fma(x, a.scale, a.shift);
  return a.relu && y < T(0) ? T(0) : y;
}

template <class T>
void activation_forward(const Activation<T>& a, const PoolShape& s, Plane<const T> src, Plane<T> dst) {
  if (a.pooling == Pooling::none) {
    for_each_row_value(src, [&](int i, int j) { dst.data[i * dst.row + j] = activate(a, src.data[i * src.row + j]); });
    return;
  }
  for_each_window(s, [&](int, int i, int j, int l) {
    const auto value = [&](int ky, int kx) {
      return activate(a, get(src, i * s.stride_rows + ky, j * s.stride_columns + kx, l));
    };
    T sum = T(0), best = value(0, 0);
    for (int ky = 0; ky < s.kernel_rows; ++ky)
      for (int kx = 0; kx < s.kernel_columns; ++kx) {
        sum += value(ky, kx);
        if (is_larger(value(ky, kx), best)) best = value(ky, kx);
      }
    const T factor = T(1) / static_cast<T>(s.kernel_rows * s.kernel_columns);
    dst.data[i * dst.row + j * lanes + l] = a.pooling == Pooling::max ? best : sum * factor;
  });
}

template <class T>
void activation_backward(const Activation<T>& a, const PoolShape& s, Plane<const T> src, Plane<const T> diff_dst,
                         Plane<T> diff) {
  const auto masked = [&](int i, int j, T d) {
    return a.relu && !(activate(a, src.data[i * src.row + j]) > T(0)) ? T(0) : d;
  };
  if (a.pooling == Pooling::none) {
    for_each_row_value(
        src, [&](int i, int j) { diff.data[i * diff.row + j] = masked(i, j, diff_dst.data[i * diff_dst.row + j]); });
    return;
  }
  const BlockView<T> diff_view{diff.data, 0, diff.row};
  clear(s, diff_view);
  const T factor = T(1) / static_cast<T>(s.kernel_rows * s.kernel_columns);
  for_each_window(s, [&](int, int i, int j, int l) {
    const int row = i * s.stride_rows, column = j * s.stride_columns;
    const T dy = get(diff_dst, i, j, l);
    int best_row = row, best_column = column;
    for (int y = row; y < row + s.kernel_rows; ++y)
      for (int x = column; x < column + s.kernel_columns; ++x) {
        if (a.pooling == Pooling::average) at(diff_view, 0, y, x, l) += dy * factor;
        if (is_larger(activate(a, get(src, y, x, l)), activate(a, get(src, best_row, best_column, l)))) {
          best_row = y;
          best_column = x;
        }
      }
    if (a.pooling == Pooling::max) at(diff_view, 0, best_row, best_column, l) += dy;
  });
  for_each_row_value(diff,
                     [&](int i, int j) { diff.data[i * diff.row + j] = masked(i, j, diff.data[i * diff.row + j]); });
}

template <class T>
void statistics_pool_forward(Plane<const T> src, T epsilon, T* mean, T* stddev) {
  const T share = T(1) / static_cast<T>(src.rows * src.columns);
  for (int l = 0; l < lanes; ++l) {
    T sum = T(0), squares = T(0);
    for (int i = 0; i < src.rows; ++i)
      for (int j = 0; j < src.columns; ++j) sum += get(src, i, j, l);
    mean[l] = sum * share;
    for (int i = 0; i < src.rows; ++i)
      for (int j = 0; j < src.columns; ++j) {
        const T off = get(src, i, j, l) - mean[l];
        squares = std::fma(off, off, squares);
      }
    stddev[l] = std::sqrt(std::fma(squares, share, epsilon));
  }
}

template <class T>
void statistics_pool_backward(Plane<const T> src, const T* mean, const T* stddev, const T* diff_mean,
                              const T* diff_stddev, Plane<T> diff_src) {
  const T share = T(1) / static_cast<T>(src.rows * src.columns);
  for (int i = 0; i < src.rows; ++i)
    for (int j = 0; j < src.columns; ++j)
      for (int l = 0; l < lanes; ++l)
        diff_src.data[i * diff_src.row + j * lanes + l] =
            std::fma(diff_stddev[l] * share / stddev[l], get(src, i, j, l) - mean[l], diff_mean[l] * share);
}

double sigmoid_of(Sigmoid kind, double x) {
  if (kind == Sigmoid::logistic) return 1 / (1 + exp(-x));
  if (kind == Sigmoid::gelu) return x * normal_distribution(x);
  const double size = std::abs(x);
  if (!(size < 20)) return x > 0 ? 1 : x < 0 ? -1 : x;  // NaN stays one
  const double square = exp(2 * size), y = (square - 1) / (square + 1);
  return x < 0 ? -y : y;
}

template <class T>
void sigmoid_forward(Sigmoid kind, Plane<const T> src, Plane<T> dst) {
  for_each_row_value(src, [&](int i, int j) {
    dst.data[i * dst.row + j] = static_cast<T>(sigmoid_of(kind, static_cast<double>(src.data[i * src.row + j])));
  });
}

template <class T>
void gelu_backward(Plane<const T> src, Plane<const T> diff_dst, Plane<T> diff_src) {
  for_each_row_value(src, [&](int i, int j) {
    const auto x = static_cast<double>(src.data[i * src.row + j]);
    diff_src.data[i * diff_src.row + j] =
        diff_dst.data[i * diff_dst.row + j] * static_cast<T>(normal_distribution(x) + x * normal_density(x));
  });
}

template <class T>
void sgd_step(std::size_t count, T learning_rate, T momentum, T weight_decay, const T* gradient, T* velocity,
              T* value) {
  for (std::size_t i = 0; i < count; ++i) {
    velocity[i] = std::fma(momentum, velocity[i], std::fma(weight_decay, value[i], gradient[i]));
    value[i] = std::fma(-learning_rate, velocity[i], value[i]);
  }
}

template <class T>
constexpr Kernels<T> table{
    "reference",
    conv2d_forward<T>,
    conv2d_backward_src<T>,
    conv2d_backward_weight<T>,
    fully_connected_forward<T>,
    fully_connected_backward_src<T>,
    fully_connected_backward_weight<T>,
    conv2d_single<T>,
    batchnorm_sums<T>,
    batchnorm_backward_sums<T>,
    batchnorm_backward_apply<T>,
    activation_forward<T>,
    activation_backward<T>,
    relu_forward<T>,
    relu_backward<T>,
    average_pool_forward<T>,
    average_pool_backward<T>,
    max_pool_forward<T>,
    max_pool_backward<T>,
    statistics_pool_forward<T>,
    statistics_pool_backward<T>,
    sgd_step<T>,
    sigmoid_forward<T>,
    gelu_backward<T>,
};

}  // namespace

template <class T>
const Kernels<T>& reference_kernels() {
  return table<T>;
}

template const Kernels<float>& reference_kernels();
template const Kernels<double>& reference_kernels();

}  // namespace decid::nn
