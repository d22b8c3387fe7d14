// Measurement noise of the blocks by its spectrum: their reordering, the misfit of the coefficients, whitening, and
// missing blocks, written once on a vector type V. kernels.hpp documents them.
#pragma once

#include "base/math/doubles.hpp"
#include "base/math/math_lanes.hpp"
#include "posterior/kernels/generic_matrix.hpp"
#include "posterior/kernels/generic_value.hpp"

namespace decid::posterior {
namespace {

template <class V>
void unfold(int count, const double* recorded, const double* modelled, const double* factors, double* out) {
  for (std::ptrdiff_t m = 0; m < count; ++m) {
    const typename V::D factor = V::set(factors[m]), value = V::set(recorded[m]);
    const std::ptrdiff_t to = unfolded_place(m, count) * lanes;
    for (int v = 0; v < vectors<V>; ++v)
      V::store(out + to + v * V::width, V::fma(-V::load(modelled + m * lanes + v * V::width), factor, value));
  }
}

template <class V>
void fold(int count, const double* unfolded, const double* factors, double* out) {
  for (std::ptrdiff_t m = 0; m < count; ++m) {
    const typename V::D factor = V::set(factors[m]);
    const std::ptrdiff_t from = unfolded_place(m, count) * lanes;
    for (int v = 0; v < vectors<V>; ++v)
      V::store(out + m * lanes + v * V::width, V::load(unfolded + from + v * V::width) * factor);
  }
}

template <class V>
void noise_rows(const NoiseRows& rows, const NoiseVariances& variances, const double* spectrum, const NoiseState& state,
                double* sums) {
  using D = typename V::D;
  // The product of this many powers, in rad^2, is representable, so one logarithm suffices.
  constexpr std::ptrdiff_t at_once = 16;
  const D one = V::set(1.0);
  for (int v = 0; v < vectors<V>; ++v) {
    const std::ptrdiff_t at = v * V::width;
    const D white = V::load(variances.white + at), slow = V::load(variances.slow + at),
            memory = V::load(variances.memory + at);
    D squares = V::set(0.0), along = squares, of_line = squares, logarithm = squares, product = one;
    for (std::ptrdiff_t k = 0; k < rows.count; ++k) {
      const D value = Value<V>::real_product(Value<V>::load(spectrum, k, v), Value<V>::same(rows.turn + 2 * k));
      const D slow_fraction = one / V::fma(V::set(rows.square[k]), memory, one);
      D power = V::fma(slow, slow_fraction, white * V::set(rows.white[k]));
      if (k == 0) power = power + V::set(rows.first);
      const D precision = one / power, line = V::set(rows.line[k]);
      const D weighed = value * precision;
      squares = V::fma(value, weighed, squares);
      along = V::fma(line, weighed, along);
      of_line = V::fma(line * line, precision, of_line);
      product = product * power;
      if (k % at_once == at_once - 1 || k + 1 == rows.count) {
        logarithm = logarithm + log_lanes<V>(product);
        product = one;
      }
      const std::ptrdiff_t to = k * lanes + at;
      V::store(state.coefficient + to, value);
      V::store(state.precision + to, precision);
      V::store(state.slow_fraction + to, slow_fraction);
    }
    V::store(sums + at, squares);
    V::store(sums + lanes + at, along);
    V::store(sums + 2 * lanes + at, of_line);
    V::store(sums + 3 * lanes + at, logarithm);
  }
}

template <class V>
void noise_rows_gradient(const NoiseRows& rows, const NoiseVariances& variances, const double* rise,
                         const double* uncertainty, const NoiseState& state, double* spectrum, double* sums) {
  using D = typename V::D;
  const D half = V::set(0.5), one = V::set(1.0);
  for (int v = 0; v < vectors<V>; ++v) {
    const std::ptrdiff_t at = v * V::width;
    const D slow = V::load(variances.slow + at), height = V::load(rise + at), variance = V::load(uncertainty + at);
    D by_white = V::set(0.0), by_slow = by_white, by_memory = by_white;
    for (std::ptrdiff_t k = 0; k < rows.count; ++k) {
      const std::ptrdiff_t from = k * lanes + at;
      const D precision = V::load(state.precision + from), slow_fraction = V::load(state.slow_fraction + from);
      const D line = V::set(rows.line[k]), error = V::fma(-line, height, V::load(state.coefficient + from));
      const D by_value = error * precision, line_weight = line * precision;
      const D by_power = half * (V::fma(-by_value, by_value, precision) - line_weight * (line_weight * variance));
      by_white = V::fma(by_power, V::set(rows.white[k]), by_white);
      by_slow = V::fma(by_power, slow_fraction, by_slow);
      by_memory = V::fma(-by_power * slow, slow_fraction * (one - slow_fraction), by_memory);
      (Value<V>::same(rows.back + 2 * k) * by_value).store(spectrum, k, v);
    }
    V::store(sums + at, by_white);
    V::store(sums + lanes + at, by_slow);
    V::store(sums + 2 * lanes + at, by_memory);
  }
}

template <class V>
void whiten(const NoiseRows& rows, const double* spectrum, const double* root, const double* line_row,
            const double* shrinkage, double* out) {
  using D = typename V::D;
  for (int v = 0; v < vectors<V>; ++v) {
    const std::ptrdiff_t at = v * V::width;
    D along = V::set(0.0);
    for (std::ptrdiff_t k = 0; k < rows.count; ++k) {
      const std::ptrdiff_t here = k * lanes + at;
      const D value = Value<V>::real_product(Value<V>::load(spectrum, k, v), Value<V>::same(rows.turn + 2 * k)) *
                      V::load(root + here);
      along = V::fma(value, V::load(line_row + here), along);
      V::store(out + here, value);
    }
    along = -along * V::load(shrinkage + at);
    for (std::ptrdiff_t k = 0; k < rows.count; ++k) {
      const std::ptrdiff_t here = k * lanes + at;
      V::store(out + here, V::fma(along, V::load(line_row + here), V::load(out + here)));
    }
  }
}

/// Four missing blocks at a time share the loads of a column.
template <class V>
void missing_columns(const MissingBasis& of, const double* precision, const double* line_variance, double* columns,
                     double* rise, double* matrix) {
  using D = typename V::D;
  const std::ptrdiff_t rows = of.rows, count = of.count;
  for (int v = 0; v < vectors<V>; ++v) {
    const std::ptrdiff_t at = v * V::width;
    for (std::ptrdiff_t c = 0; c < count; ++c) {
      D along = V::set(0.0);
      for (std::ptrdiff_t k = 0; k < rows; ++k)
        along = V::fma(V::set(of.line[k] * of.basis[k * count + c]), V::load(precision + k * lanes + at), along);
      const D height = along * V::load(line_variance + at);
      V::store(rise + c * lanes + at, height);
      double* column = columns + c * rows * lanes + at;
      for (std::ptrdiff_t k = 0; k < rows; ++k)
        V::store(column + k * lanes, V::load(precision + k * lanes + at) *
                                         V::fma(V::set(-of.line[k]), height, V::set(of.basis[k * count + c])));
      double* row = matrix + c * (c + 1) / 2 * lanes + at;
      std::ptrdiff_t j = 0;
      for (; j + 4 <= c + 1; j += 4) {
        D sum[4] = {V::set(0.0), V::set(0.0), V::set(0.0), V::set(0.0)};
        for (std::ptrdiff_t k = 0; k < rows; ++k) {
          const D here = V::load(column + k * lanes);
          const double* basis = of.basis + k * count + j;
#pragma GCC unroll 4
          for (int n = 0; n < 4; ++n) sum[n] = V::fma(V::set(basis[n]), here, sum[n]);
        }
        for (int n = 0; n < 4; ++n) V::store(row + (j + n) * lanes, sum[n]);
      }
      for (; j <= c; ++j) {
        D sum = V::set(0.0);
        for (std::ptrdiff_t k = 0; k < rows; ++k)
          sum = V::fma(V::set(of.basis[k * count + j]), V::load(column + k * lanes), sum);
        V::store(row + j * lanes, sum);
      }
      V::store(row + c * lanes, V::load(row + c * lanes) + V::set(of.prior_precision));
    }
  }
}

template <class V>
void column_powers(const NoiseRows& rows, int count, const double* slow, const double* slow_fraction,
                   const double* columns, const double* weights, double* sums) {
  using D = typename V::D;
  const D one = V::set(1.0);
  for (int v = 0; v < vectors<V>; ++v) {
    const std::ptrdiff_t at = v * V::width;
    const D height = V::load(slow + at);
    D by_white = V::set(0.0), by_slow = by_white, by_memory = by_white;
    for (std::ptrdiff_t k = 0; k < rows.count; ++k) {
      D power = V::set(0.0);
      for (std::ptrdiff_t c = 0; c < count; ++c) {
        const D value = V::load(columns + (c * rows.count + k) * lanes + at);
        power = V::fma(value * value, V::load(weights + c * lanes + at), power);
      }
      const D fraction = V::load(slow_fraction + k * lanes + at);
      by_white = V::fma(power, V::set(rows.white[k]), by_white);
      by_slow = V::fma(power, fraction, by_slow);
      by_memory = V::fma(-power * height, fraction * (one - fraction), by_memory);
    }
    V::store(sums + at, by_white);
    V::store(sums + lanes + at, by_slow);
    V::store(sums + 2 * lanes + at, by_memory);
  }
}

}  // namespace
}  // namespace decid::posterior
