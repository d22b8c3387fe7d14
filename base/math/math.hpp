// Elementary functions with reproducible bits: fixed chains of IEEE additions, multiplications, divisions, square roots
// and explicit fused multiply-adds. Versions of libm differ between systems, these do not. Methods: argument reduction
// and Taylor or Chebyshev polynomials; the tests verify the stated bounds.
#pragma once

namespace decid {

/// The sine and cosine of a fraction of a turn: sin(2 pi n / d), cos(2 pi n / d). The reduction to an octant is exact
/// (integers). Absolute error below 2.3e-16. 0 < d <= 2^52; n may be any integer.
struct SinCos {
  double sin, cos;
};
SinCos sincos_of_turn(long long n, long long d) noexcept;
/// The sine and cosine of an angle given in turns, whose part of a turn is rounded down to 2^-52.
SinCos sincos_of_turns(double turns) noexcept;

/// Returns sin(x), and the next function cos(x), for |x| <= 0.5 rad; relative error below 2.5e-16.
double sin_small(double x) noexcept;
double cos_small(double x) noexcept;

/// Returns the natural logarithm of a normal x > 0; error below 2 units in the last place.
double log(double x) noexcept;

/// Returns e^x, relative error below 4.5e-16; 0 for x < -700, infinity for x > 700, NaN for NaN.
double exp(double x) noexcept;

/// Returns the standard normal distribution function; relative error below 2e-14 for x >= -8 and 3e-13 for x >= -37, 0
/// below, NaN for NaN.
double normal_distribution(double x) noexcept;
/// Returns its derivative.
double normal_density(double x) noexcept;

/// Returns the angle of (x, y) in (-pi, pi]; atan2(0, 0) = 0; error below 3 units in the last place.
double atan2(double y, double x) noexcept;

/// Returns asinh(x), relative error below 1e-15.
double asinh(double x) noexcept;

}  // namespace decid
