// Elementary functions whose bits we promise: fixed chains of IEEE additions, multiplications, divisions, square
// roots and explicit fused multiply-adds. libm's versions differ between systems, these do not.
// Methods: argument reduction and Taylor or Chebyshev polynomials; the stated bounds are what the tests hold them to.
#pragma once

namespace decid {

/// A turn's sine and cosine: sin(2 pi n / d), cos(2 pi n / d). The reduction to an octant is exact (integers).
/// Absolute error below 2.3e-16. 0 < d <= 2^52; n may be any integer.
struct SinCos {
  double sin, cos;
};
SinCos sincos_of_turn(long long n, long long d) noexcept;

/// sin(x) for |x| <= 0.5 rad; relative error below 2.5e-16.
/// A template, so that a type of several lanes has the same bits in each of them: plain multiply and add, no branch.
/// Taylor to x^15 in two halves: the chain of dependent operations is half as long as Horner's.
template <class Real>
Real sin_small(Real x) noexcept {
  const Real z = x * x;
  const Real z2 = z * z;
  const Real low = (z * (1.0 / 120) - 1.0 / 6) + z2 * (z * (1.0 / 362880) - 1.0 / 5040);
  const Real high = (z * (1.0 / 6227020800) - 1.0 / 39916800) - z2 * (1.0 / 1307674368000);
  return x + x * z * (low + z2 * z2 * high);
}

/// cos(x) for |x| <= 0.5 rad; relative error below 2.5e-16. As sin_small; Taylor to x^14.
template <class Real>
Real cos_small(Real x) noexcept {
  const Real z = x * x;
  const Real z2 = z * z;
  const Real low = (1.0 / 24 - z * (1.0 / 720)) + z2 * (1.0 / 40320 - z * (1.0 / 3628800));
  const Real high = 1.0 / 479001600 - z * (1.0 / 87178291200);
  // 1 - z / 2 is rounded; what it lost is added back with the small terms.
  const Real half = 0.5 * z;
  const Real top = 1.0 - half;
  return top + (((1.0 - top) - half) + z2 * (low + z2 * z2 * high));
}

/// Natural logarithm of a normal x > 0; error below 2 units in the last place.
double log(double x) noexcept;

/// e^x for |x| <= 700; relative error below 4.5e-16.
double exp(double x) noexcept;

/// The standard normal distribution function, relative error below 1e-14 for x >= -37; 0 far below.
double normal_distribution(double x) noexcept;

/// Angle of (x, y) in (-pi, pi]; atan2(0, 0) = 0; error below 3 units in the last place.
double atan2(double y, double x) noexcept;

/// asinh(x), relative error below 1e-15.
double asinh(double x) noexcept;

}  // namespace decid
