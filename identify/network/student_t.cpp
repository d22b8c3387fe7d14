// Student's t distribution: see student_t.hpp.
#include "identify/network/student_t.hpp"

#include <cmath>

#include "base/math/math.hpp"

namespace decid {
namespace {

/// Stirling's series; the recurrence brings z to 10 or more, where the first term left out is below 1e-15.
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

/// log of the beta function of degrees_of_freedom / 2 and 1 / 2.
double log_beta(double degrees_of_freedom) {
  constexpr double log_gamma_half = 0.57236494292470009;
  return log_gamma(0.5 * degrees_of_freedom) + log_gamma_half - log_gamma(0.5 * degrees_of_freedom + 0.5);
}

/// The continued fraction of I_x(a, b) a B(a, b) / (x^a (1 - x)^b), by Lentz's algorithm; quick for
/// x < (a + 1) / (a + b + 2).
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

}  // namespace

double student_t_tails(double t, double degrees_of_freedom) {
  if (t == 0.0) return 1.0;
  const double a = 0.5 * degrees_of_freedom, b = 0.5, sum = degrees_of_freedom + t * t;
  const double x = degrees_of_freedom / sum, y = t * t / sum;
  const double front = exp(a * log(x) + b * log(y) - log_beta(degrees_of_freedom));
  return x < (a + 1.0) / (a + b + 2.0) ? front * beta_fraction(a, b, x) / a : 1.0 - front * beta_fraction(b, a, y) / b;
}

double student_t_critical(double probability, double degrees_of_freedom) {
  // The tails fall and are convex, so Newton's method comes from the left and never oversteps.
  double t = 0.0;
  for (int step = 0; step < 200; ++step) {
    const double log_density = -0.5 * (degrees_of_freedom + 1.0) * log(1.0 + t * t / degrees_of_freedom) -
                               0.5 * log(degrees_of_freedom) - log_beta(degrees_of_freedom);
    const double next = t + 0.5 * (student_t_tails(t, degrees_of_freedom) - probability) / exp(log_density);
    if (!(next > t * (1.0 + 1e-14))) break;
    t = next;
  }
  return t;
}

}  // namespace decid
