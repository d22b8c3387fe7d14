// Symmetric positive definite matrices and lower triangles, row after row: row i has i + 1 values. Every value of a
// factor and of an inverse is one chain of fused multiply-adds, so the bits are the same everywhere.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace decid {

/// Returns the index at which row i begins; for i = size, the number of values.
constexpr std::size_t triangle(std::size_t i) {
  return i * (i + 1) / 2;
}

/// Replaces A by its Cholesky factor L, A = L L^t. Returns false if A is not positive definite or not finite; A is then
/// undefined.
bool factorize(std::size_t size, std::span<double> matrix);
/// Replaces L by its inverse.
void invert_lower(std::size_t size, std::span<double> lower);
/// Replaces y by L^-1 y.
void solve_lower(std::size_t size, std::span<const double> lower, std::span<double> y);
/// Replaces y by L^-t y.
void solve_upper(std::size_t size, std::span<const double> lower, std::span<double> y);

}  // namespace decid
