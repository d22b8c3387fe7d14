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

/// Four rows at a time share what they load.
template <class V>
void add_matrix_times(int rows, int columns, const double* matrix, const double* in, double* out) {
  using D = typename V::D;
  for (int v = 0; v < vectors<V>; ++v) {
    const double* x = in + v * V::width;
    double* y = out + v * V::width;
    std::ptrdiff_t i = 0;
    for (; i + 4 <= rows; i += 4) {
      const double *r0 = matrix + i * columns, *r1 = r0 + columns, *r2 = r1 + columns, *r3 = r2 + columns;
      D a = V::load(y + i * lanes), b = V::load(y + (i + 1) * lanes), c = V::load(y + (i + 2) * lanes),
        d = V::load(y + (i + 3) * lanes);
      for (std::ptrdiff_t j = 0; j < columns; ++j) {
        const D xj = V::load(x + j * lanes);
        a = V::fma(V::set(r0[j]), xj, a);
        b = V::fma(V::set(r1[j]), xj, b);
        c = V::fma(V::set(r2[j]), xj, c);
        d = V::fma(V::set(r3[j]), xj, d);
      }
      V::store(y + i * lanes, a);
      V::store(y + (i + 1) * lanes, b);
      V::store(y + (i + 2) * lanes, c);
      V::store(y + (i + 3) * lanes, d);
    }
    for (; i < rows; ++i) {
      D a = V::load(y + i * lanes);
      for (std::ptrdiff_t j = 0; j < columns; ++j)
        a = V::fma(V::set(matrix[i * columns + j]), V::load(x + j * lanes), a);
      V::store(y + i * lanes, a);
    }
  }
}

/// Rows from the top; four rows at a time share the rows above that they read.
template <class V>
void factorize(int size, double* matrix) {
  using D = typename V::D;
  const auto row = [matrix](std::ptrdiff_t i) { return matrix + i * (i + 1) / 2 * lanes; };
  for (int v = 0; v < vectors<V>; ++v) {
    const std::ptrdiff_t at = v * V::width;
    const auto finish = [&](std::ptrdiff_t i, std::ptrdiff_t from) {  // columns from `from` of row i
      double* here = row(i) + at;
      for (std::ptrdiff_t j = from; j <= i; ++j) {
        const double* above = row(j) + at;
        D value = V::load(here + j * lanes);
        for (std::ptrdiff_t k = 0; k < j; ++k)
          value = V::fma(-V::load(here + k * lanes), V::load(above + k * lanes), value);
        V::store(here + j * lanes, j < i ? value / V::load(above + j * lanes) : V::sqrt(value));
      }
    };
    std::ptrdiff_t i = 0;
    for (; i + 4 <= size; i += 4) {
      double *r0 = row(i) + at, *r1 = row(i + 1) + at, *r2 = row(i + 2) + at, *r3 = row(i + 3) + at;
      for (std::ptrdiff_t j = 0; j < i; ++j) {
        const double* above = row(j) + at;
        D a = V::load(r0 + j * lanes), b = V::load(r1 + j * lanes), c = V::load(r2 + j * lanes),
          d = V::load(r3 + j * lanes);
        for (std::ptrdiff_t k = 0; k < j; ++k) {
          const D factor = -V::load(above + k * lanes);
          a = V::fma(factor, V::load(r0 + k * lanes), a);
          b = V::fma(factor, V::load(r1 + k * lanes), b);
          c = V::fma(factor, V::load(r2 + k * lanes), c);
          d = V::fma(factor, V::load(r3 + k * lanes), d);
        }
        const D diagonal = V::load(above + j * lanes);
        V::store(r0 + j * lanes, a / diagonal);
        V::store(r1 + j * lanes, b / diagonal);
        V::store(r2 + j * lanes, c / diagonal);
        V::store(r3 + j * lanes, d / diagonal);
      }
      for (std::ptrdiff_t r = 0; r < 4; ++r) finish(i + r, i);
    }
    for (; i < size; ++i) finish(i, 0);
  }
}

/// Rows from the last: each is taken off what is left.
template <class V>
void solve_transposed(int size, const double* lower, double* x) {
  using D = typename V::D;
  for (int v = 0; v < vectors<V>; ++v) {
    double* values = x + v * V::width;
    for (std::ptrdiff_t i = size - 1; i >= 0; --i) {
      const double* row = lower + i * (i + 1) / 2 * lanes + v * V::width;
      const D here = V::load(values + i * lanes) / V::load(row + i * lanes);
      V::store(values + i * lanes, here);
      for (std::ptrdiff_t j = 0; j < i; ++j)
        V::store(values + j * lanes, V::fma(-here, V::load(row + j * lanes), V::load(values + j * lanes)));
    }
  }
}

template <class V>
void symmetric_times(int size, const double* matrix, const double* in, double* out) {
  using D = typename V::D;
  for (int v = 0; v < vectors<V>; ++v) {
    const double* x = in + v * V::width;
    double* y = out + v * V::width;
    for (std::ptrdiff_t i = 0; i < size; ++i) {
      const double* row = matrix + i * (i + 1) / 2 * lanes + v * V::width;
      const D xi = V::load(x + i * lanes);
      D sum = V::load(y + i * lanes);
      for (std::ptrdiff_t j = 0; j < i; ++j) {
        const D value = V::load(row + j * lanes);
        sum = V::fma(value, V::load(x + j * lanes), sum);
        V::store(y + j * lanes, V::fma(value, xi, V::load(y + j * lanes)));
      }
      V::store(y + i * lanes, V::fma(V::load(row + i * lanes), xi, sum));
    }
  }
}

template <class V>
void stretch(int count, double* root, double* cube, double* values, double* product) {
  using D = typename V::D;
  for (int v = 0; v < vectors<V>; ++v) {
    D all = V::set(1.0);
    for (std::ptrdiff_t i = v * V::width; i < std::ptrdiff_t{count} * lanes; i += lanes) {
      const D q = V::set(0.25) * V::load(root + i), square = q * q;
      V::store(root + i, q);
      V::store(cube + i, square * q);
      V::store(values + i, V::load(values + i) * (square * square));
      all = all * q;
    }
    V::store(product + v * V::width, all);
  }
}

template <class V>
void stretch_gradient(int count, const double* root, const double* cube, const double* values, double* gradient,
                      double* by_root) {
  using D = typename V::D;
  for (std::ptrdiff_t i = 0; i < std::ptrdiff_t{count} * lanes; i += V::width) {
    const D q = V::load(root + i), third = V::load(cube + i), by = V::load(gradient + i);
    V::store(by_root + i, V::fma(by * third, V::load(values + i), -(V::set(1.0) / q)));
    V::store(gradient + i, by * (third * q));
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
