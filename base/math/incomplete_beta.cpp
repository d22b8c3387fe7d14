// The incomplete beta function: see incomplete_beta.hpp.
#include "base/math/incomplete_beta.hpp"

#include <cmath>

#include "base/math/math.hpp"

namespace decid {

// Stirling's series; the recurrence brings z to 10 or more, where the first term left out is below 1e-15.
double log_gamma(double z) {
  double product = 1.0;
  for (; z < 10.0; z += 1.0) product *= z;
  const double i = 1.0 / (z * z);
  const double series =
      (1.0 / 12.0 -
       i * (1.0 / 360.0 - i * (1.0 / 1260.0 - i * (1.0 / 1680.0 - i * (1.0 / 1188.0 - i * 691.0 / 360360.0))))) /
      z;
  constexpr double half_log_two_pi = 0.91893853320467274;
  return (z - 0.5) * log(z) - z + half_log_two_pi + series - log(product);
}

// By Lentz's algorithm.
double beta_fraction(double a, double b, double x) {
  double c = 1.0, d = 1.0 / (1.0 - (a + b) * x / (a + 1.0)), value = d;
  for (int step = 1; step <= 10'000; ++step) {
    const double m = step;
    const double even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
    d = 1.0 / (1.0 + even * d);
    c = 1.0 + even / c;
    value *= d * c;
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
    d = 1.0 / (1.0 + odd * d);
    c = 1.0 + odd / c;
    value *= d * c;
    if (std::abs(d * c - 1.0) < 1e-15) break;
  }
  return value;
}

double incomplete_beta(double a, double b, double x) {
  if (x <= 0.0 || x >= 1.0) return x <= 0.0 ? 0.0 : 1.0;
  const double front = exp(a * log(x) + b * log(1.0 - x) - (log_gamma(a) + log_gamma(b) - log_gamma(a + b)));
  return x < (a + 1.0) / (a + b + 2.0) ? front * beta_fraction(a, b, x) / a
                                       : 1.0 - front * beta_fraction(b, a, 1.0 - x) / b;
}

double f_tail(double f, double numerator, double denominator) {
  // The smaller part keeps the digits of small tails.
  return incomplete_beta(0.5 * denominator, 0.5 * numerator, denominator / (denominator + numerator * f));
}

double f_critical(double probability, double numerator, double denominator) {
  double low = -200.0, high = 200.0;  // logarithms
  for (int halving = 0; halving < 80; ++halving) {
    const double middle = 0.5 * (low + high);
    (f_tail(exp(middle), numerator, denominator) > probability ? low : high) = middle;
  }
  return exp(0.5 * (low + high));
}

}  // namespace decid
