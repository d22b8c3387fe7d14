// Mean and standard deviation of planes, and their derivatives.
#pragma once

#include "nn/kernels/generic_plane.hpp"

namespace decid::nn {
namespace {

template <class V>
void statistics_pool_forward(Plane<const float> src, float epsilon, float* mean, float* stddev) {
  using Float = typename V::Float;
  const Float inverse_count = V::broadcast(1 / static_cast<float>(src.rows * src.columns));
  for (int l = 0; l < lanes; l += V::width) {
    Float sum = V::broadcast(0), squares = sum;
    for (int i = 0; i < src.rows; ++i)
      for (int j = 0; j < src.columns; ++j) sum = V::add(sum, V::load(src.data + i * src.row + j * lanes + l));
    const Float middle = V::mul(sum, inverse_count);
    for (int i = 0; i < src.rows; ++i)
      for (int j = 0; j < src.columns; ++j) {
        const Float off = V::sub(V::load(src.data + i * src.row + j * lanes + l), middle);
        squares = V::fma(off, off, squares);
      }
    V::store(mean + l, middle);
    V::store(stddev + l, V::fma(squares, inverse_count, V::broadcast(epsilon)));
  }
  for (int l = 0; l < lanes; ++l) stddev[l] = __builtin_sqrtf(stddev[l]);
}

template <class V>
void statistics_pool_backward(Plane<const float> src, const float* mean, const float* stddev, const float* diff_mean,
                              const float* diff_stddev, Plane<float> diff_src) {
  using Float = typename V::Float;
  const float inverse_count = 1 / static_cast<float>(src.rows * src.columns);
  float slope[lanes], shift[lanes];
  for (int l = 0; l < lanes; ++l) {
    slope[l] = diff_stddev[l] * inverse_count / stddev[l];
    shift[l] = diff_mean[l] * inverse_count;
  }
  for (int l = 0; l < lanes; l += V::width) {
    const Float middle = V::load(mean + l), a = V::load(shift + l), b = V::load(slope + l);
    for (int i = 0; i < src.rows; ++i)
      for (int j = 0; j < src.columns; ++j) {
        const Float off = V::sub(V::load(src.data + i * src.row + j * lanes + l), middle);
        V::store(diff_src.data + i * diff_src.row + j * lanes + l, V::fma(b, off, a));
      }
  }
}

}  // namespace
}  // namespace decid::nn
