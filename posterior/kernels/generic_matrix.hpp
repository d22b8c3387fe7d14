// Vectors, triangles and products of columns, chain by chain, written once on a vector type V (base/math/doubles.hpp).
// kernels.hpp documents them.
#pragma once

#include "base/math/doubles.hpp"
#include "posterior/kernels/kernels.hpp"

namespace decid::posterior {
namespace {

template <class V>
constexpr int vectors = lanes / V::width;

/// Four rows at a time share their loads.
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

/// Adds rows from last to first to the output, four at a time.
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

/// Four rows at a time share their loads.
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

/// Processes rows from the top; four rows at a time share the rows above.
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

template <class V>
void solve_lower(int size, const double* lower, double* x) {
  using D = typename V::D;
  for (int v = 0; v < vectors<V>; ++v) {
    double* values = x + v * V::width;
    for (std::ptrdiff_t i = 0; i < size; ++i) {
      const double* row = lower + i * (i + 1) / 2 * lanes + v * V::width;
      D here = V::load(values + i * lanes);
      for (std::ptrdiff_t j = 0; j < i; ++j)
        here = V::fma(-V::load(row + j * lanes), V::load(values + j * lanes), here);
      V::store(values + i * lanes, here / V::load(row + i * lanes));
    }
  }
}

/// Processes rows from the last: subtracts each from the remainder.
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

/// Solves for one column of the inverse after another; values above the diagonal are not computed.
template <class V>
void inverse_of_factor(int size, const double* lower, double* inverse, double* column) {
  using D = typename V::D;
  for (int v = 0; v < vectors<V>; ++v) {
    const std::ptrdiff_t at = v * V::width;
    double* x = column + at;
    const auto row = [&](std::ptrdiff_t i) { return lower + i * (i + 1) / 2 * lanes + at; };
    for (std::ptrdiff_t m = 0; m < size; ++m) {
      V::store(x + m * lanes, V::set(1.0) / V::load(row(m) + m * lanes));
      for (std::ptrdiff_t i = m + 1; i < size; ++i) {
        D sum = V::set(0.0);
        for (std::ptrdiff_t j = m; j < i; ++j) sum = V::fma(V::load(row(i) + j * lanes), V::load(x + j * lanes), sum);
        V::store(x + i * lanes, -sum / V::load(row(i) + i * lanes));
      }
      for (std::ptrdiff_t i = size - 1; i >= m; --i) {
        const D here = V::load(x + i * lanes) / V::load(row(i) + i * lanes);
        for (std::ptrdiff_t j = m; j < i; ++j)
          V::store(x + j * lanes, V::fma(-here, V::load(row(i) + j * lanes), V::load(x + j * lanes)));
        V::store(inverse + (i * (i + 1) / 2 + m) * lanes + at, here);
      }
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
void with_prior(int size, const double* factor, const double* prior, const double* values, double* gradient) {
  for (std::ptrdiff_t i = 0; i < size; ++i) {
    for (int v = 0; v < vectors<V>; ++v) {
      const std::ptrdiff_t at = i * lanes + v * V::width;
      const auto of_prior = V::load(values + at) * V::load(prior + v * V::width);
      V::store(gradient + at, V::fma(V::load(factor + v * V::width), V::load(gradient + at), of_prior));
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

template <class V>
void columns_times(int rows, int count, const double* columns, const double* in, double* out) {
  using D = typename V::D;
  for (std::ptrdiff_t c = 0; c < count; ++c) {
    for (int v = 0; v < vectors<V>; ++v) {
      const std::ptrdiff_t at = v * V::width;
      const double* column = columns + c * rows * lanes + at;
      D sum = V::set(0.0);
      for (std::ptrdiff_t k = 0; k < rows; ++k)
        sum = V::fma(V::load(column + k * lanes), V::load(in + k * lanes + at), sum);
      V::store(out + c * lanes + at, sum);
    }
  }
}

/// Keeps a block of 4 x 4 sums in registers while a strip of 4 and 4 columns passes, which fits into the first-level
/// cache. A strip of all columns fits into the second-level cache.
template <class V>
void add_products(int strips, int blocks, const double* columns, double* products) {
  using D = typename V::D;
  constexpr std::ptrdiff_t apart = std::ptrdiff_t{strip_rows} * lanes;
  for (std::ptrdiff_t strip = 0; strip < strips; ++strip, columns += 4 * blocks * apart) {
    double* sums = products;
    for (std::ptrdiff_t i = 0; i < blocks; ++i) {
      for (std::ptrdiff_t j = 0; j <= i; ++j, sums += std::ptrdiff_t{16} * lanes) {
        for (int v = 0; v < vectors<V>; ++v) {
          const std::ptrdiff_t at = v * V::width;
          const double *a = columns + 4 * i * apart + at, *b = columns + 4 * j * apart + at;
          D sum[16];
#pragma GCC unroll 16
          for (int n = 0; n < 16; ++n) sum[n] = V::load(sums + n * lanes + at);
          for (std::ptrdiff_t m = 0; m < apart; m += lanes) {
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

/// Computes rows first, ..., first + lanes - 1 of the Cholesky factor of a matrix from the rows above, interleaved in
/// `panel`: value k of row first + l at [k * lanes + l]. Returns false if a diagonal is not positive or not finite.
template <class V>
bool factorize_panel(std::ptrdiff_t first, std::ptrdiff_t last, const double* factor, double* panel) {
  using D = typename V::D;
  const auto row = [factor](std::ptrdiff_t i) { return factor + i * (i + 1) / 2; };
  for (int v = 0; v < vectors<V>; ++v) {
    double* p = panel + v * V::width;
    std::ptrdiff_t j = 0;
    for (; j + 4 <= first; j += 4) {
      const double *r0 = row(j), *r1 = row(j + 1), *r2 = row(j + 2), *r3 = row(j + 3);
      D a = V::load(p + j * lanes), b = V::load(p + (j + 1) * lanes), c = V::load(p + (j + 2) * lanes),
        d = V::load(p + (j + 3) * lanes);
      for (std::ptrdiff_t k = 0; k < j; ++k) {
        const D here = -V::load(p + k * lanes);
        a = V::fma(here, V::set(r0[k]), a);
        b = V::fma(here, V::set(r1[k]), b);
        c = V::fma(here, V::set(r2[k]), c);
        d = V::fma(here, V::set(r3[k]), d);
      }
      a = a / V::set(r0[j]);
      b = V::fma(-a, V::set(r1[j]), b) / V::set(r1[j + 1]);
      c = V::fma(-b, V::set(r2[j + 1]), V::fma(-a, V::set(r2[j]), c)) / V::set(r2[j + 2]);
      d = V::fma(-a, V::set(r3[j]), d);
      d = V::fma(-c, V::set(r3[j + 2]), V::fma(-b, V::set(r3[j + 1]), d)) / V::set(r3[j + 3]);
      V::store(p + j * lanes, a);
      V::store(p + (j + 1) * lanes, b);
      V::store(p + (j + 2) * lanes, c);
      V::store(p + (j + 3) * lanes, d);
    }
    for (; j < first; ++j) {
      D value = V::load(p + j * lanes);
      for (std::ptrdiff_t k = 0; k < j; ++k) value = V::fma(-V::load(p + k * lanes), V::set(row(j)[k]), value);
      V::store(p + j * lanes, value / V::set(row(j)[j]));
    }
  }
  for (std::ptrdiff_t j = first; j < last; ++j) {
    double diagonal = 0.0;
    for (std::ptrdiff_t l = j - first; l < last - first; ++l) {
      double value = panel[j * lanes + l];
      for (std::ptrdiff_t k = 0; k < j; ++k)
        value = __builtin_fma(-panel[k * lanes + l], panel[k * lanes + j - first], value);
      if (l == j - first) {
        if (!(value > 0.0 && __builtin_isfinite(value))) return false;
        diagonal = __builtin_sqrt(value);
      }
      panel[j * lanes + l] = l == j - first ? diagonal : value / diagonal;
    }
  }
  return true;
}

/// Computes the inverse of a factor in a square with rows `stride` apart and zeros right of the diagonal; then packs it
/// again.
template <class V>
void invert_factor(std::ptrdiff_t size, std::ptrdiff_t stride, double* factor, double* inverse) {
  using D = typename V::D;
  constexpr std::ptrdiff_t together = 4 * V::width;
  for (std::ptrdiff_t i = 0; i < size; ++i) {
    const double* row = factor + i * (i + 1) / 2;
    double* out = inverse + i * stride;
    const double diagonal = 1.0 / row[i];
    const D factor_of_row = V::set(-diagonal);
    for (std::ptrdiff_t j = 0; j < stride; j += together) {
      D a = V::set(0.0), b = a, c = a, d = a;
      for (std::ptrdiff_t k = j; k < i; ++k) {
        const double* above = inverse + k * stride + j;
        const D here = V::set(row[k]);
        a = V::fma(here, V::load(above), a);
        b = V::fma(here, V::load(above + V::width), b);
        c = V::fma(here, V::load(above + 2 * V::width), c);
        d = V::fma(here, V::load(above + 3 * V::width), d);
      }
      V::store(out + j, a * factor_of_row);
      V::store(out + j + V::width, b * factor_of_row);
      V::store(out + j + 2 * V::width, c * factor_of_row);
      V::store(out + j + 3 * V::width, d * factor_of_row);
    }
    for (std::ptrdiff_t j = i; j < stride; ++j) out[j] = j == i ? diagonal : 0.0;
  }
  for (std::ptrdiff_t i = 0; i < size; ++i)
    for (std::ptrdiff_t j = 0; j <= i; ++j) factor[i * (i + 1) / 2 + j] = inverse[i * stride + j];
}

template <class V>
bool inverse_factor(int size, double* matrix, double* work) {
  const auto row = [matrix](std::ptrdiff_t i) { return matrix + i * (i + 1) / 2; };
  for (std::ptrdiff_t first = 0; first < size; first += lanes) {
    const std::ptrdiff_t last = first + lanes < size ? first + lanes : size;
    for (std::ptrdiff_t j = 0; j < last; ++j)
      for (std::ptrdiff_t l = 0; l < lanes; ++l)
        work[j * lanes + l] = first + l < last && j <= first + l ? row(first + l)[j] : 0.0;
    if (!factorize_panel<V>(first, last, matrix, work)) return false;
    for (std::ptrdiff_t i = first; i < last; ++i)
      for (std::ptrdiff_t j = 0; j <= i; ++j) row(i)[j] = work[j * lanes + i - first];
  }
  invert_factor<V>(size, (size + 31) / 32 * 32, matrix, work);
  return true;
}

}  // namespace
}  // namespace decid::posterior
