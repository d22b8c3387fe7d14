// Arithmetic whose bits are the same with every compiler.
// Not installed.
#pragma once

#include <cmath>
#include <complex>

#include "base/aligned.hpp"
#include "base/math/math.hpp"

namespace decid::posterior {

/// Returns a / b. The operator's bits depend on the compiler's library, which may fuse operations.
inline std::complex<double> quotient(std::complex<double> a, std::complex<double> b) {
  const double square = b.real() * b.real() + b.imag() * b.imag();
  return a * std::complex<double>(b.real() / square, -(b.imag() / square));
}

/// Returns exp(2 pi i turns), |turns| below 2^12.
inline std::complex<double> turned(double turns) {
  constexpr long long parts = 1LL << 50;
  const auto [sin, cos] = sincos_of_turn(std::llround(turns * static_cast<double>(parts)), parts);
  return {cos, sin};
}

/// Appends the real and the imaginary part.
inline void put(AlignedVector<double>& values, std::complex<double> value) {
  values.push_back(value.real());
  values.push_back(value.imag());
}

}  // namespace decid::posterior
