// tanh, sigmoid and GELU, some doubles at a time: the formulas of base/math/math_lanes.hpp, whose bits are those of
// base/math/math.hpp, with which the plain definitions compute.
#pragma once

#include "base/math/math_lanes.hpp"
#include "nn/kernels/kernels.hpp"

namespace decid::nn {
namespace {

template <class D2, class D = typename D2::D>
[[gnu::always_inline]] inline D tanh_lanes(D x) {
  const D zero = D2::set(0.0), one = D2::set(1.0), size = D2::abs(x);
  const D square = exp_lanes<D2>(2.0 * size);
  const D y = (square - 1.0) / (square + 1.0);
  const D limit = x > zero ? one : (x < zero ? -one : x);  // NaN stays one
  return size < D2::set(20.0) ? (x < zero ? -y : y) : limit;
}

/// Calls f(row, place in the row) for every register of doubles of a plane.
template <class D2, class T, class F>
[[gnu::always_inline]] inline void for_each_doubles(const Plane<T>& plane, const F& f) {
  static_assert(lanes % D2::width == 0);
  for (int i = 0; i < plane.rows; ++i)
    for (int j = 0; j < plane.columns * lanes; j += D2::width) f(i, j);
}

template <class D2, class F>
[[gnu::always_inline]] inline void map_doubles(Plane<const float> src, Plane<float> dst, const F& f) {
  for_each_doubles<D2>(src, [&](int i, int j) {
    D2::store_floats(dst.data + i * dst.row + j, f(D2::load_floats(src.data + i * src.row + j)));
  });
}

template <class D2>
void sigmoid_forward(Sigmoid kind, Plane<const float> src, Plane<float> dst) {
  using D = typename D2::D;
  if (kind == Sigmoid::tanh) map_doubles<D2>(src, dst, [](D x) { return tanh_lanes<D2>(x); });
  if (kind == Sigmoid::logistic) map_doubles<D2>(src, dst, [](D x) { return 1.0 / (1.0 + exp_lanes<D2>(-x)); });
  if (kind == Sigmoid::gelu) map_doubles<D2>(src, dst, [](D x) { return x * normal_distribution_lanes<D2>(x); });
}

template <class D2>
void gelu_backward(Plane<const float> src, Plane<const float> diff_dst, Plane<float> diff_src) {
  using D = typename D2::D;
  for_each_doubles<D2>(src, [&](int i, int j) {
    const D x = D2::load_floats(src.data + i * src.row + j);
    float slope[D2::width];
    D2::store_floats(slope, normal_distribution_lanes<D2>(x) + x * normal_density_lanes<D2>(x));
    const float* const dy = diff_dst.data + i * diff_dst.row + j;
    float* const dx = diff_src.data + i * diff_src.row + j;
    for (int lane = 0; lane < D2::width; ++lane) dx[lane] = dy[lane] * slope[lane];
  });
}

}  // namespace
}  // namespace decid::nn
