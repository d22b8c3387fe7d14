// Batch normalisation, ReLU and the optimiser's step: one pass over memory each, which is what bounds them.
#pragma once

#include "nn/kernels/generic_lanes.hpp"

namespace decid::nn {
namespace {

/// Calls f(row, value of the row) for every register of a plane.
template <class V, class T, class F>
[[gnu::always_inline]] inline void for_each_register(const Plane<T>& plane, const F& f) {
  for (int i = 0; i < plane.rows; ++i)
    for (int j = 0; j < plane.columns * lanes; j += V::width) f(i, j);
}

/// Chains of R rows at once, each of two sums of 16 lanes, onto sums in double, row after row. f(row, value of the
/// row, first, second) continues both chains of a register.
template <class V, int R, class F>
[[gnu::always_inline]] inline void sum_rows(int row, int columns, double* sums, const F& f) {
  constexpr int parts_of_row = lanes / V::width;
  typename V::Float a[R][parts_of_row], b[R][parts_of_row];
  for (int r = 0; r < R; ++r)
    for (int p = 0; p < parts_of_row; ++p) a[r][p] = b[r][p] = V::broadcast(0);
  for (int j = 0; j < columns; ++j)
    for (int r = 0; r < R; ++r)
      for (int p = 0; p < parts_of_row; ++p) f(row + r, j * lanes + p * V::width, a[r][p], b[r][p]);
  alignas(64) float row_sum[R][2 * lanes];
  for (int r = 0; r < R; ++r)
    for (int p = 0; p < parts_of_row; ++p) {
      V::store(row_sum[r] + p * V::width, a[r][p]);
      V::store(row_sum[r] + lanes + p * V::width, b[r][p]);
    }
  // Four sums side by side: planes of one column come here with every value.
  using Doubles = double __attribute__((vector_size(32)));
  unroll<2 * lanes / 4>([&](auto k) {
    Doubles sum;
    __builtin_memcpy(&sum, sums + 4 * k, sizeof sum);
    for (int r = 0; r < R; ++r) sum += __builtin_convertvector(load_quad(row_sum[r] + 4 * k), Doubles);
    __builtin_memcpy(sums + 4 * k, &sum, sizeof sum);
  });
}

/// Two sums over rows from `row` on. A row's chain waits for its own last addition, so as many rows go side by side as
/// give eight registers of chains; of those left over again as many as there are.
template <class V, int R, class F>
[[gnu::always_inline]] inline void plane_sums(int row, int rows, int columns, double* sums, const F& f) {
  for (; row + R <= rows; row += R) sum_rows<V, R>(row, columns, sums, f);
  if constexpr (R > 1) plane_sums<V, R / 2>(row, rows, columns, sums, f);
}
template <class V, class F>
[[gnu::always_inline]] inline void plane_sums(int rows, int columns, double* sums, const F& f) {
  plane_sums<V, larger(1, 4 * V::width / lanes)>(0, rows, columns, sums, f);
}

template <class V>
void batchnorm_sums(Plane<const float> src, float pivot, double sums[2 * lanes]) {
  using Float = typename V::Float;
  const Float centre = V::broadcast(pivot);
  plane_sums<V>(src.rows, src.columns, sums, [&](int i, int j, Float& sum, Float& square) {
    const Float d = V::sub(V::load(src.data + i * src.row + j), centre);
    sum = V::add(sum, d);
    square = V::fma(d, d, square);
  });
}

template <class V>
void batchnorm_backward_sums(Plane<const float> src, Plane<const float> diff_dst, float mean, double sums[2 * lanes]) {
  using Float = typename V::Float;
  const Float centre = V::broadcast(mean);
  plane_sums<V>(src.rows, src.columns, sums, [&](int i, int j, Float& sum, Float& dot) {
    const Float dy = V::load(diff_dst.data + i * diff_dst.row + j);
    sum = V::add(sum, dy);
    dot = V::fma(dy, V::sub(V::load(src.data + i * src.row + j), centre), dot);
  });
}

template <class V>
void batchnorm_backward_apply(Plane<const float> src, Plane<const float> diff_dst, float a, float b, float c,
                              Plane<float> diff_src) {
  const typename V::Float va = V::broadcast(a), vb = V::broadcast(b), vc = V::broadcast(c);
  for_each_register<V>(src, [&](int i, int j) {
    const typename V::Float inner = V::fma(vb, V::load(src.data + i * src.row + j), vc);
    V::store(diff_src.data + i * diff_src.row + j, V::fma(va, V::load(diff_dst.data + i * diff_dst.row + j), inner));
  });
}

template <class V>
void relu_forward(Plane<float> value) {
  const typename V::Float zero = V::broadcast(0);
  for_each_register<V>(value, [&](int i, int j) {
    float* p = value.data + i * value.row + j;
    const typename V::Float v = V::load(p);
    V::store(p, V::if_greater(zero, v, zero, v));
  });
}

template <class V>
void relu_backward(Plane<const float> value, Plane<float> diff) {
  const typename V::Float zero = V::broadcast(0);
  for_each_register<V>(value, [&](int i, int j) {
    float* p = diff.data + i * diff.row + j;
    V::store(p, V::if_greater(V::load(value.data + i * value.row + j), zero, V::load(p), zero));
  });
}

/// Momentum and step of V::width parameters.
template <class V>
[[gnu::always_inline]] inline void sgd_register(float learning_rate, float momentum, float weight_decay,
                                                const float* gradient, float* velocity, float* value) {
  using Float = typename V::Float;
  const Float old = V::load(value);
  const Float regularised = V::fma(V::broadcast(weight_decay), old, V::load(gradient));
  const Float v = V::fma(V::broadcast(momentum), V::load(velocity), regularised);
  V::store(velocity, v);
  V::store(value, V::fma(V::broadcast(-learning_rate), v, old));
}

template <class V>
void sgd_step(std::size_t count, float learning_rate, float momentum, float weight_decay, const float* gradient,
              float* velocity, float* value) {
  constexpr std::size_t width = V::width;
  std::size_t i = 0;
  for (; i + width <= count; i += width)
    sgd_register<V>(learning_rate, momentum, weight_decay, gradient + i, velocity + i, value + i);
  if (i == count) return;
  float tail[3][width] = {};
  for (std::size_t k = i; k < count; ++k) {
    tail[0][k - i] = gradient[k];
    tail[1][k - i] = velocity[k];
    tail[2][k - i] = value[k];
  }
  sgd_register<V>(learning_rate, momentum, weight_decay, tail[0], tail[1], tail[2]);
  for (std::size_t k = i; k < count; ++k) {
    velocity[k] = tail[1][k - i];
    value[k] = tail[2][k - i];
  }
}

}  // namespace
}  // namespace decid::nn
