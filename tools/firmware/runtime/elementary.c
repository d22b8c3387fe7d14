/* ---- Elementary functions -------------------------------------------------------------------------------------------
   The chains of operations of decid's base/math/math_lanes.hpp, for one value; that file has methods and bounds. */

#if USES_LOG
/* Natural logarithm of a normal x > 0. */
static double natural_log(double x) {
  static const double coefficient[10] = {2.0 / 21, 2.0 / 19, 2.0 / 17, 2.0 / 15, 2.0 / 13,
                                         2.0 / 11, 2.0 / 9,  2.0 / 7,  2.0 / 5,  2.0 / 3};
  const double ln2_high = 6.93147180369123816490e-01;
  const double ln2_low = 1.90821492927058770002e-10;
  const uint64_t bits = bits_of(x);
  double exponent = (double)((int32_t)((bits >> 52) & 0x7ffU) - 1023);
  double mantissa = double_of((bits & 0x000fffffffffffffU) | 0x3ff0000000000000U);
  double f;
  double s;
  double z;
  double r;
  double half_square;
  int32_t i;
  if (mantissa > 1.4142135623730951) {
    mantissa = mantissa * 0.5;
    exponent = exponent + 1.0;
  }
  f = mantissa - 1.0;
  s = f / (2.0 + f);
  z = s * s;
  r = coefficient[0];
  for (i = 1; i < 10; ++i) {
    r = (r * z) + coefficient[i];
  }
  r = r * z;
  half_square = 0.5 * f * f;
  return (exponent * ln2_high) - ((half_square - ((s * (half_square + r)) + (exponent * ln2_low))) - f);
}
#endif

#if USES_ASINH
static double inverse_sinh(double x) {
  const double ln2 = 6.93147180369123816490e-01 + 1.90821492927058770002e-10;
  const double a = (x < 0.0) ? -x : x;
  double value;
  if (!(a <= 1.7976931348623157e308)) {
    return x; /* infinities and NaN are their own */
  }
  if (a > 268435456.0) {
    value = natural_log(a) + ln2;
  } else {
    const double y = a + ((a * a) / (1.0 + square_root((a * a) + 1.0)));
    const double u = 1.0 + y;
    const double lost = (y < 1.0) ? (y - (u - 1.0)) : (1.0 - (u - y));
    value = natural_log(u) + (lost / u);
  }
  return (x < 0.0) ? -value : value;
}
#endif

#if USES_EXPONENTIAL
static double floor_of(double x) {
  const double whole = (double)(int32_t)x;
  return (whole > x) ? (whole - 1.0) : whole;
}

/* e^x */
static double exponential(double x) {
  static const double coefficient[12] = {1.0 / 6227020800.0, 1.0 / 479001600.0, 1.0 / 39916800.0, 1.0 / 3628800.0,
                                         1.0 / 362880.0,     1.0 / 40320.0,     1.0 / 5040.0,     1.0 / 720.0,
                                         1.0 / 120.0,        1.0 / 24.0,        1.0 / 6.0,        0.5};
  double k;
  double r;
  double sum = coefficient[0];
  int32_t i;
  if (!(x >= -700.0)) {
    return (x < 0.0) ? 0.0 : x; /* NaN stays */
  }
  k = floor_of((x * 1.4426950408889634) + 0.5);
  r = (x - (k * 6.93147180369123816490e-01)) - (k * 1.90821492927058770002e-10);
  for (i = 1; i < 12; ++i) {
    sum = (sum * r) + coefficient[i];
  }
  return (1.0 + (r + ((r * r) * sum))) * double_of((uint64_t)((int32_t)k + 1023) << 52);
}

#endif

#if USES_DENSITY
static double normal_density(double x) {
  return 0.39894228040143268 * exponential((-0.5 * x) * x);
}
#endif

#if USES_NORMAL
static double ratio_of(const double* numerator, const double* denominator, int32_t count, double x) {
  double above = numerator[0];
  double below = denominator[0];
  int32_t i;
  for (i = 1; i < count; ++i) {
    above = fma_double(above, x, numerator[i]);
    below = fma_double(below, x, denominator[i]);
  }
  return above / below;
}

/* e^(-x^2), 0 <= x < 2^26. */
static double gauss(double x) {
  const double high = floor_of(x * 16.0) / 16.0;
  return exponential(-high * high) * exponential(-(x - high) * (x + high));
}

/* The standard normal distribution function. */
static double normal_distribution(double x) {
  static const double small_p[5] = {1.85777706184603153e-1, 3.16112374387056560e0, 1.13864154151050156e2,
                                    3.77485237685302021e2, 3.20937758913846947e3};
  static const double small_q[5] = {1.0, 2.36012909523441209e1, 2.44024637934444173e2, 1.28261652607737228e3,
                                    2.84423683343917062e3};
  static const double middle_p[9] = {2.15311535474403846e-8, 5.64188496988670089e-1, 8.88314979438837594e0,
                                     6.61191906371416295e1,  2.98635138197400131e2,  8.81952221241769090e2,
                                     1.71204761263407058e3,  2.05107837782607147e3,  1.23033935479799725e3};
  static const double middle_q[9] = {1.0,
                                     1.57449261107098347e1,
                                     1.17693950891312499e2,
                                     5.37181101862009858e2,
                                     1.62138957456669019e3,
                                     3.29079923573345963e3,
                                     4.36261909014324716e3,
                                     3.43936767414372164e3,
                                     1.23033935480374942e3};
  static const double large_p[6] = {1.63153871373020978e-2, 3.05326634961232344e-1, 3.60344899949804439e-1,
                                    1.25781726111229246e-1, 1.60837851487422766e-2, 6.58749161529837803e-4};
  static const double large_q[6] = {1.0,
                                    2.56852019228982242e0,
                                    1.87295284992346047e0,
                                    5.27905102951428412e-1,
                                    6.05183413124413191e-2,
                                    2.33520497626869185e-3};
  const double sqrt_half = 0.70710678118654752;
  const double y = ((x < 0.0) ? -x : x) * sqrt_half;
  double tail = 0.0; /* erfc(y) */
  if (y <= 0.46875) {
    return 0.5 + ((0.5 * (x * sqrt_half)) * ratio_of(small_p, small_q, 5, y * y));
  }
  if (y <= 4.0) {
    tail = gauss(y) * ratio_of(middle_p, middle_q, 9, y);
  } else if (y < 26.5) {
    const double z = 1.0 / (y * y);
    tail = (gauss(y) / y) * (0.56418958354775629 - (z * ratio_of(large_p, large_q, 6, z)));
  } else {
    /* 0 */
  }
  return (x < 0.0) ? (0.5 * tail) : (1.0 - (0.5 * tail));
}
#endif

#if USES_TANH
static double hyperbolic_tangent(double x) {
  const double size = (x < 0.0) ? -x : x;
  double y;
  if (!(size < 20.0)) {
    y = (size >= 20.0) ? 1.0 : size; /* NaN stays */
  } else {
    const double square = exponential(2.0 * size);
    y = (square - 1.0) / (square + 1.0);
  }
  return (x < 0.0) ? -y : y;
}
#endif

#if USES_SIGMOID
/* 1 / (1 + e^-x); e^700 is finite, above it the quotient is 0. */
static double logistic(double x) {
  return (x < -700.0) ? 0.0 : (1.0 / (1.0 + exponential(-x)));
}
#endif
