// The activation after a normalisation, in one pass over a plane: scale and shift, ReLU, and a pool whose windows do
// not overlap. Backward recomputes the values in between, in registers. Windows of 2 x 2, the common case, are
// unrolled; others loop.
#pragma once

#include "nn/kernels/generic_pool.hpp"

namespace decid::nn {
namespace {

/// Constants that are fixed when the loops are compiled; Size: rows and columns of a window, 0 to take them from the
/// shape.
template <bool Relu, Pooling Kind, int Size>
struct ActivationKind {
  static constexpr bool relu = Relu;
  static constexpr Pooling pooling = Kind;
  static constexpr int size = Size;
};

/// The normalised value, after ReLU if there is one.
template <class V, class K>
[[gnu::always_inline]] inline typename V::Float activated(const float* x, typename V::Float scale,
                                                          typename V::Float shift) {
  const typename V::Float y = V::fma(V::load(x), scale, shift), zero = V::broadcast(0);
  return K::relu ? V::if_greater(zero, y, zero, y) : y;
}

/// Returns the derivative behind ReLU, masked by the sign of `value`.
template <class V, class K>
[[gnu::always_inline]] inline typename V::Float masked(typename V::Float value, typename V::Float diff) {
  const typename V::Float zero = V::broadcast(0);
  return K::relu ? V::if_greater(value, zero, diff, zero) : diff;
}

/// Calls f(ActivationKind) with the kind that `a` and the shape require.
template <class F>
[[gnu::always_inline]] inline void with_kind(const Activation<float>& a, const PoolShape& s, const F& f) {
  const auto with_relu = [&](auto pooling, auto size) {
    if (a.relu)
      f(ActivationKind<true, pooling(), size()>{});
    else
      f(ActivationKind<false, pooling(), size()>{});
  };
  const auto with_size = [&](auto pooling) {
    if (s.kernel_rows == 2 && s.kernel_columns == 2)
      with_relu(pooling, std::integral_constant<int, 2>{});
    else
      with_relu(pooling, std::integral_constant<int, 0>{});
  };
  if (a.pooling == Pooling::none)
    with_relu(std::integral_constant<Pooling, Pooling::none>{}, std::integral_constant<int, 1>{});
  if (a.pooling == Pooling::average) with_size(std::integral_constant<Pooling, Pooling::average>{});
  if (a.pooling == Pooling::max) with_size(std::integral_constant<Pooling, Pooling::max>{});
}

template <class V, class K>
void activate_plane(const Activation<float>& a, Plane<const float> src, Plane<float> dst) {
  const typename V::Float scale = V::broadcast(a.scale), shift = V::broadcast(a.shift);
  for_each_register<V>(src, [&](int i, int j) {
    __builtin_prefetch(src.data + (i + 1) * src.row + j);
    V::store(dst.data + i * dst.row + j, activated<V, K>(src.data + i * src.row + j, scale, shift));
  });
}

template <class V, class K>
void activate_windows(const Activation<float>& a, const PoolShape& s, Plane<const float> src, Plane<float> dst) {
  using Float = typename V::Float;
  const Float scale = V::broadcast(a.scale), shift = V::broadcast(a.shift);
  const int rows = K::size > 0 ? K::size : s.kernel_rows, columns = K::size > 0 ? K::size : s.kernel_columns;
  const Float factor = V::broadcast(1 / static_cast<float>(rows * columns));
  for (int i = 0; i < s.dst_rows; ++i)
    for (int j = 0; j < s.dst_columns; ++j)
      for (int l = 0; l < lanes; l += V::width) {
        const float* const x = src.data + i * s.stride_rows * src.row + j * s.stride_columns * lanes + l;
        Float result = K::pooling == Pooling::max ? activated<V, K>(x, scale, shift) : V::broadcast(0);
        for (int ky = 0; ky < rows; ++ky)
          for (int kx = 0; kx < columns; ++kx) {
            __builtin_prefetch(x + (s.stride_rows + ky) * src.row + kx * lanes);
            const Float value = activated<V, K>(x + ky * src.row + kx * lanes, scale, shift);
            result =
                K::pooling == Pooling::max ? V::if_greater_or_nan(value, result, value, result) : V::add(result, value);
          }
        V::store(dst.data + i * dst.row + j * lanes + l, K::pooling == Pooling::max ? result : V::mul(result, factor));
      }
}

template <class V>
void activation_forward(const Activation<float>& a, const PoolShape& s, Plane<const float> src, Plane<float> dst) {
  with_kind(a, s, [&](auto kind) {
    using K = decltype(kind);
    if constexpr (K::pooling == Pooling::none)
      activate_plane<V, K>(a, src, dst);
    else
      activate_windows<V, K>(a, s, src, dst);
  });
}

template <class V, class K>
void differentiate_plane(const Activation<float>& a, Plane<const float> src, Plane<const float> diff_dst,
                         Plane<float> diff) {
  const typename V::Float scale = V::broadcast(a.scale), shift = V::broadcast(a.shift);
  for_each_register<V>(src, [&](int i, int j) {
    __builtin_prefetch(src.data + (i + 1) * src.row + j);
    const typename V::Float value = activated<V, K>(src.data + i * src.row + j, scale, shift);
    V::store(diff.data + i * diff.row + j, masked<V, K>(value, V::load(diff_dst.data + i * diff_dst.row + j)));
  });
}

template <class V, class K>
void differentiate_windows(const Activation<float>& a, const PoolShape& s, Plane<const float> src,
                           Plane<const float> diff_dst, Plane<float> diff) {
  using Float = typename V::Float;
  const Float scale = V::broadcast(a.scale), shift = V::broadcast(a.shift), zero = V::broadcast(0);
  const int rows = K::size > 0 ? K::size : s.kernel_rows, columns = K::size > 0 ? K::size : s.kernel_columns;
  const Float factor = V::broadcast(1 / static_cast<float>(rows * columns));
  clear_for_windows<V>(s, {diff.data, 0, diff.row}, false);
  for (int i = 0; i < s.dst_rows; ++i)
    for (int j = 0; j < s.dst_columns; ++j)
      for (int l = 0; l < lanes; l += V::width) {
        const std::ptrdiff_t column = static_cast<std::ptrdiff_t>(j) * s.stride_columns * lanes + l;
        const float* const x = src.data + i * s.stride_rows * src.row + column;
        float* const dx = diff.data + i * s.stride_rows * diff.row + column;
        const Float dy = V::load(diff_dst.data + i * diff_dst.row + j * lanes + l);
        // 0 + share even where nothing else is added: it turns -0 into +0.
        const Float share = V::add(zero, K::pooling == Pooling::max ? dy : V::mul(dy, factor));
        // The window's values: kept if they fit in registers, otherwise recomputed.
        Float kept[larger(1, K::size * K::size)];
        const auto make = [&](int ky, int kx) { return activated<V, K>(x + ky * src.row + kx * lanes, scale, shift); };
        if constexpr (K::size > 0) unroll<K::size * K::size>([&](auto k) { kept[k] = make(k / K::size, k % K::size); });
        const auto value = [&](int ky, int kx) { return K::size > 0 ? kept[ky * K::size + kx] : make(ky, kx); };
        // The number of the first largest value, or of the last NaN, counted in float: exact up to 2^24 values.
        Float best = value(0, 0), best_at = zero;
        if constexpr (K::pooling == Pooling::max)
          for (int ky = 0; ky < rows; ++ky)
            for (int kx = 0; kx < columns; ++kx) {
              const Float at = V::broadcast(static_cast<float>(ky * columns + kx));
              best_at = V::if_greater_or_nan(value(ky, kx), best, at, best_at);
              best = V::if_greater_or_nan(value(ky, kx), best, value(ky, kx), best);
            }
        for (int ky = 0; ky < rows; ++ky)
          for (int kx = 0; kx < columns; ++kx) {
            Float place = share;
            if constexpr (K::pooling == Pooling::max) {
              const Float at = V::broadcast(static_cast<float>(ky * columns + kx));
              // Equal if neither is greater.
              place = V::if_greater(at, best_at, zero, V::if_greater(best_at, at, zero, share));
            }
            __builtin_prefetch(x + (s.stride_rows + ky) * src.row + kx * lanes);
            V::store(dx + ky * diff.row + kx * lanes, masked<V, K>(value(ky, kx), place));
          }
      }
}

template <class V>
void activation_backward(const Activation<float>& a, const PoolShape& s, Plane<const float> src,
                         Plane<const float> diff_dst, Plane<float> diff) {
  with_kind(a, s, [&](auto kind) {
    using K = decltype(kind);
    if constexpr (K::pooling == Pooling::none)
      differentiate_plane<V, K>(a, src, diff_dst, diff);
    else
      differentiate_windows<V, K>(a, s, src, diff_dst, diff);
  });
}

}  // namespace
}  // namespace decid::nn
