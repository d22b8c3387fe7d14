// Cholesky factors: see cholesky.hpp. Rows are processed from left to right (Cholesky-Banachiewicz).
#include "base/math/cholesky.hpp"

#include <algorithm>
#include <cmath>

namespace decid {

bool factorize(std::size_t size, std::span<double> matrix) {
  for (std::size_t i = 0; i < size; ++i) {
    double* row = matrix.data() + triangle(i);
    for (std::size_t j = 0; j <= i; ++j) {
      const double* other = matrix.data() + triangle(j);
      double value = row[j];
      for (std::size_t k = 0; k < j; ++k) value = std::fma(-row[k], other[k], value);
      if (j < i) {
        row[j] = value / other[j];
        continue;
      }
      if (!(value > 0.0 && std::isfinite(value))) return false;
      row[j] = std::sqrt(value);
    }
  }
  return true;
}

void invert_lower(std::size_t size, std::span<double> lower) {
  std::vector<double> row_in(size);
  for (std::size_t i = 0; i < size; ++i) {
    // Row i of the inverse: -(row i of L, without its diagonal) (inverse above) / diagonal.
    double* row = lower.data() + triangle(i);
    std::copy_n(row, i + 1, row_in.begin());
    const double diagonal = 1.0 / row_in[i];
    std::fill_n(row, i, 0.0);
    for (std::size_t k = 0; k < i; ++k) {
      const double* above = lower.data() + triangle(k);
      for (std::size_t j = 0; j <= k; ++j) row[j] = std::fma(row_in[k], above[j], row[j]);
    }
    for (std::size_t j = 0; j < i; ++j) row[j] *= -diagonal;
    row[i] = diagonal;
  }
}

void solve_lower(std::size_t size, std::span<const double> lower, std::span<double> y) {
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t k = 0; k < i; ++k) y[i] -= lower[triangle(i) + k] * y[k];
    y[i] /= lower[triangle(i) + i];
  }
}

void solve_upper(std::size_t size, std::span<const double> lower, std::span<double> y) {
  for (std::size_t i = size; i-- > 0;) {
    y[i] /= lower[triangle(i) + i];
    for (std::size_t k = 0; k < i; ++k) y[k] -= lower[triangle(i) + k] * y[i];
  }
}

}  // namespace decid
