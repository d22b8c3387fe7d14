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

template <class V>
void missing_matrix(const MissingPairs& of, const double* cosines, const double* along, const double* rise,
                    double* matrix) {
  using D = typename V::D;
  const D half = V::set(0.5);
  for (int v = 0; v < vectors<V>; ++v) {
    const std::ptrdiff_t at = v * V::width;
    for (std::ptrdiff_t i = 0, pair = 0; i < of.count; ++i) {
      const D of_row = -V::load(along + i * lanes + at);
      for (std::ptrdiff_t j = 0; j <= i; ++j, ++pair) {
        const D sum = V::load(cosines + of.apart[pair] * std::ptrdiff_t{lanes} + at) +
                      V::load(cosines + of.sum[pair] * std::ptrdiff_t{lanes} + at);
        V::store(matrix + pair * lanes + at, V::fma(of_row, V::load(rise + j * lanes + at), half * sum));
      }
      double* diagonal = matrix + (pair - 1) * lanes + at;
      V::store(diagonal, V::load(diagonal) + V::set(of.prior_precision));
    }
  }
}

template <class V>
void add_to_distances(const MissingPairs& of, const double* matrix, double* distances) {
  using D = typename V::D;
  const D half = V::set(0.5);
  for (int v = 0; v < vectors<V>; ++v) {
    const std::ptrdiff_t at = v * V::width;
    for (std::ptrdiff_t i = 0, pair = 0; i < of.count; ++i) {
      for (std::ptrdiff_t j = 0; j <= i; ++j, ++pair) {
        const D here = V::load(matrix + pair * lanes + at), both = j < i ? here : half * here;
        double *apart = distances + of.apart[pair] * std::ptrdiff_t{lanes} + at,
               *sum = distances + of.sum[pair] * std::ptrdiff_t{lanes} + at;
        V::store(apart, V::load(apart) + both);
        V::store(sum, V::load(sum) + both);
      }
    }
  }
}

template <class V>
void missing_powers(const NoiseRows& rows, const double* slow, const NoiseState& state, const double* trace,
                    const double* along, const double* square, double* sums) {
  using D = typename V::D;
  const D one = V::set(1.0), minus_half = V::set(-0.5), two = V::set(2.0);
  for (int v = 0; v < vectors<V>; ++v) {
    const std::ptrdiff_t at = v * V::width;
    const D height = V::load(slow + at), of_line = V::load(square + at);
    D by_white = V::set(0.0), by_slow = by_white, by_memory = by_white;
    for (std::ptrdiff_t k = 0; k < rows.count; ++k) {
      const std::ptrdiff_t from = k * lanes + at;
      const D line = V::set(rows.line[k]), precision = V::load(state.precision + from),
              fraction = V::load(state.slow_fraction + from);
      const D all = V::fma(line, V::fma(line, of_line, -(two * V::load(along + from))), V::load(trace + from));
      const D power = minus_half * (precision * precision) * all;
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
