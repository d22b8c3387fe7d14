// What densities share beside base/math.hpp.
// Not installed.
#pragma once

#include <complex>

#include "base/math.hpp"

namespace decid::posterior {

/// a / b. The operator's bits are those of the compiler's library, which fuses where it likes.
inline std::complex<double> quotient(std::complex<double> a, std::complex<double> b) {
  const double square = b.real() * b.real() + b.imag() * b.imag();
  return a * std::complex<double>(b.real() / square, -(b.imag() / square));
}

/// Density of the standard normal distribution.
inline double normal_density(double x) {
  return 0.39894228040143268 * decid::exp(-0.5 * x * x);
}

}  // namespace decid::posterior
