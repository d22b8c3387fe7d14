// Vectors, triangles and products of columns, chain by chain, written once on a vector type V (base/doubles.hpp). What
// each computes is in kernels.hpp.
#pragma once

#include "base/doubles.hpp"
#include "identify/posterior/kernels/kernels.hpp"

namespace decid::posterior {
namespace {

template <class V>
constexpr int vectors = lanes / V::width;

/// Four rows at a time share what they load.
template <class V>
void lower_times(int size, const double* lower, const double* in, double* out) {
  using D = typename V::D;
  const auto row = [lower](std::ptrdiff_t i) { return lower + i * (i + 1) / 2; };
  for (int v = 0; v < vectors<V>; ++v) {
    const double* x = in + v * V::width;
    double* y = out + v * V::width;
    std::ptrdiff_t i = 0;
    for (; i + 4 <= size; i += 4) {
      const double *r0 = row(i), *r1 = row(i + 1), *r2 = row(i + 2), *r3 = row(i + 3);
      D a = V::set(0.0), b = a, c = a, d = a;
      for (std::ptrdiff_t j = 0; j <= i; ++j) {
        const D xj = V::load(x + j * lanes);
        a = V::fma(V::set(r0[j]), xj, a);
        b = V::fma(V::set(r1[j]), xj, b);
        c = V::fma(V::set(r2[j]), xj, c);
        d = V::fma(V::set(r3[j]), xj, d);
      }
      const D x1 = V::load(x + (i + 1) * lanes), x2 = V::load(x + (i + 2) * lanes), x3 = V::load(x + (i + 3) * lanes);
      b = V::fma(V::set(r1[i + 1]), x1, b);
      c = V::fma(V::set(r2[i + 2]), x2, V::fma(V::set(r2[i + 1]), x1, c));
      d = V::fma(V::set(r3[i + 3]), x3, V::fma(V::set(r3[i + 2]), x2, V::fma(V::set(r3[i + 1]), x1, d)));
      V::store(y + i * lanes, a);
      V::store(y + (i + 1) * lanes, b);
      V::store(y + (i + 2) * lanes, c);
      V::store(y + (i + 3) * lanes, d);
    }
    for (; i < size; ++i) {
      D a = V::set(0.0);
      for (std::ptrdiff_t j = 0; j <= i; ++j) a = V::fma(V::set(row(i)[j]), V::load(x + j * lanes), a);
      V::store(y + i * lanes, a);
    }
  }
}

/// Rows from the last to the first are added to what comes out; four rows at a time.
template <class V>
void upper_times(int size, const double* lower, const double* in, double* out) {
  using D = typename V::D;
  const auto row = [lower](std::ptrdiff_t i) { return lower + i * (i + 1) / 2; };
  for (int v = 0; v < vectors<V>; ++v) {
    const double* x = in + v * V::width;
    double* y = out + v * V::width;
    for (std::ptrdiff_t j = 0; j < size; ++j) V::store(y + j * lanes, V::set(0.0));
    std::ptrdiff_t i = 0;
    for (; i + 4 <= size; i += 4) {
      const double *r0 = row(i), *r1 = row(i + 1), *r2 = row(i + 2), *r3 = row(i + 3);
      const D x0 = V::load(x + i * lanes), x1 = V::load(x + (i + 1) * lanes), x2 = V::load(x + (i + 2) * lanes),
              x3 = V::load(x + (i + 3) * lanes);
      for (std::ptrdiff_t j = 0; j <= i; ++j) {
        D sum = V::fma(V::set(r0[j]), x0, V::load(y + j * lanes));
        sum = V::fma(V::set(r1[j]), x1, sum);
        sum = V::fma(V::set(r2[j]), x2, sum);
        V::store(y + j * lanes, V::fma(V::set(r3[j]), x3, sum));
      }
      V::store(y + (i + 1) * lanes,
               V::fma(V::set(r3[i + 1]), x3, V::fma(V::set(r2[i + 1]), x2, V::set(r1[i + 1]) * x1)));
      V::store(y + (i + 2) * lanes, V::fma(V::set(r3[i + 2]), x3, V::set(r2[i + 2]) * x2));
      V::store(y + (i + 3) * lanes, V::set(r3[i + 3]) * x3);
    }
    for (; i < size; ++i) {
      const D xi = V::load(x + i * lanes);
      for (std::ptrdiff_t j = 0; j <= i; ++j)
        V::store(y + j * lanes, V::fma(V::set(row(i)[j]), xi, V::load(y + j * lanes)));
    }
  }
}

template <class V>
void add_times(int size, const double* factor, const double* by, double* values) {
  for (std::ptrdiff_t i = 0; i < size; ++i) {
    for (int v = 0; v < vectors<V>; ++v) {
      const std::ptrdiff_t at = i * lanes + v * V::width;
      V::store(values + at, V::fma(V::load(factor + v * V::width), V::load(by + at), V::load(values + at)));
    }
  }
}

template <class V>
void subtract_times(int size, const double* factor, const double* by, double* values) {
  for (std::ptrdiff_t i = 0; i < size; ++i) {
    for (int v = 0; v < vectors<V>; ++v) {
      const std::ptrdiff_t at = i * lanes + v * V::width;
      V::store(values + at, V::fma(-V::load(factor + v * V::width), V::load(by + at), V::load(values + at)));
    }
  }
}

template <class V>
void squares(int size, const double* values, double* sums) {
  for (int v = 0; v < vectors<V>; ++v) {
    typename V::D sum = V::set(0.0);
    for (std::ptrdiff_t i = 0; i < size; ++i) {
      const typename V::D value = V::load(values + i * lanes + v * V::width);
      sum = V::fma(value, value, sum);
    }
    V::store(sums + v * V::width, sum);
  }
}

/// A block of 4 x 4 sums stays in registers while 32 rows of 4 and 4 columns pass by, which fit into the first cache.
template <class V>
void add_products(int rows, int blocks, const double* columns, double* products) {
  using D = typename V::D;
  constexpr std::ptrdiff_t most = 32;
  const std::ptrdiff_t apart = std::ptrdiff_t{rows} * lanes;
  for (std::ptrdiff_t first = 0; first < rows; first += most) {
    const std::ptrdiff_t last = first + most < rows ? first + most : rows;
    double* sums = products;
    for (std::ptrdiff_t i = 0; i < blocks; ++i) {
      for (std::ptrdiff_t j = 0; j <= i; ++j, sums += std::ptrdiff_t{16} * lanes) {
        for (int v = 0; v < vectors<V>; ++v) {
          const std::ptrdiff_t at = v * V::width;
          const double *a = columns + 4 * i * apart + at, *b = columns + 4 * j * apart + at;
          D sum[16];
#pragma GCC unroll 16
          for (int n = 0; n < 16; ++n) sum[n] = V::load(sums + n * lanes + at);
          for (std::ptrdiff_t m = first * lanes; m < last * lanes; m += lanes) {
            D right[4];
#pragma GCC unroll 4
            for (int n = 0; n < 4; ++n) right[n] = V::load(b + n * apart + m);
#pragma GCC unroll 4
            for (int r = 0; r < 4; ++r) {
              const D left = V::load(a + r * apart + m);
#pragma GCC unroll 4
              for (int n = 0; n < 4; ++n) sum[4 * r + n] = V::fma(left, right[n], sum[4 * r + n]);
            }
          }
#pragma GCC unroll 16
          for (int n = 0; n < 16; ++n) V::store(sums + n * lanes + at, sum[n]);
        }
      }
    }
  }
}

}  // namespace
}  // namespace decid::posterior
