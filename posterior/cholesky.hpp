// Symmetric positive definite matrices and lower triangles, row after row: row i has i + 1 values. Every value is one
// chain of fused multiply-adds, so the bits are the same everywhere.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace decid::posterior {

/// Where row i begins; with the size in place of i, how many values there are.
constexpr std::size_t triangle(std::size_t i) {
  return i * (i + 1) / 2;
}

/// A becomes its Cholesky factor L, A = L L^t. False if A is not positive definite or not finite; A is void then.
bool factorize(std::size_t size, std::span<double> matrix);
/// L becomes its inverse.
void invert_lower(std::size_t size, std::span<double> lower);

}  // namespace decid::posterior
