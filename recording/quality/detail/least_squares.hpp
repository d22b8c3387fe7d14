// Small least-squares problems of checks of the sway, whose unknowns the data may not all determine. Not installed.
// base/math/cholesky.hpp refuses such equations.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace decid::recording {

/// Replaces a by its Cholesky factor L and b by L^-1 b; skips unknowns that the equations do not determine. Returns
/// |L^-1 b|^2, the sum of squares that the fit explains.
template <std::size_t N>
double eliminate(std::array<std::array<double, N>, N>& a, std::array<double, N>& b) {
  double explained = 0.0;
  for (std::size_t i = 0; i < N; ++i) {
    const double min_pivot = 1e-9 * a[i][i];
    for (std::size_t j = 0; j < i; ++j) {
      double sum = a[i][j];
      for (std::size_t k = 0; k < j; ++k) sum -= a[i][k] * a[j][k];
      a[i][j] = sum * a[j][j];
    }
    double sum = a[i][i];
    for (std::size_t k = 0; k < i; ++k) sum -= a[i][k] * a[i][k];
    a[i][i] = sum > min_pivot ? 1.0 / std::sqrt(sum) : 0.0;  // its inverse
    for (std::size_t k = 0; k < i; ++k) b[i] -= a[i][k] * b[k];
    b[i] *= a[i][i];
    explained += b[i] * b[i];
  }
  return explained;
}

/// Solves a x = b and writes x to b.
template <std::size_t N>
void solve(std::array<std::array<double, N>, N> a, std::array<double, N>& b) {
  eliminate(a, b);
  for (std::size_t i = N; i-- > 0;) {
    for (std::size_t k = i + 1; k < N; ++k) b[i] -= a[k][i] * b[k];
    b[i] *= a[i][i];
  }
}

/// Returns the number of blocks times the relative decrease of the residual; 0 for a perfect fit.
inline double gain_of(std::size_t blocks, double worse, double better) {
  return better > 0.0 ? static_cast<double>(blocks) * (worse / better - 1.0) : 0.0;
}

}  // namespace decid::recording
