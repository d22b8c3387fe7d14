// A positive definite matrix to factorize.
#pragma once

#include <vector>

#include "base/math/cholesky.hpp"
#include "base/math/random.hpp"

namespace decid::test {

/// A A^t of random rows, and 1 on the diagonal: positive definite.
inline std::vector<double> positive_definite(std::size_t size) {
  std::vector<double> rows(size * size), matrix(triangle(size));
  Random(4, Stream{10}, size).fill_normal(rows);
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = i == j ? 1.0 : 0.0;
      for (std::size_t k = 0; k < size; ++k) sum += rows[i * size + k] * rows[j * size + k];
      matrix[triangle(i) + j] = sum;
    }
  }
  return matrix;
}

}  // namespace decid::test
