// Student's t distribution: see student_t.hpp.
#include "identify/network/student_t.hpp"

#include "base/math/incomplete_beta.hpp"
#include "base/math/math.hpp"

namespace decid {
namespace {

/// log of the beta function of degrees_of_freedom / 2 and 1 / 2.
double log_beta(double degrees_of_freedom) {
  constexpr double log_gamma_half = 0.57236494292470009;
  return log_gamma(0.5 * degrees_of_freedom) + log_gamma_half - log_gamma(0.5 * degrees_of_freedom + 0.5);
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
