// Arithmetic whose bits are the same with every compiler.
// Not installed.
#pragma once

#include <complex>

namespace decid::posterior {

/// a / b. The operator's bits are those of the compiler's library, which fuses where it likes.
inline std::complex<double> quotient(std::complex<double> a, std::complex<double> b) {
  const double square = b.real() * b.real() + b.imag() * b.imag();
  return a * std::complex<double>(b.real() / square, -(b.imag() / square));
}

}  // namespace decid::posterior
