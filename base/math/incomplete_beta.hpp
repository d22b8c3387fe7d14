// The incomplete beta function, behind Student's t and Fisher's F; the same bits on every machine. DLMF 8.17.22
// (continued fraction) and 5.11.1 (Stirling's series).
#pragma once

namespace decid {

/// Returns log(gamma(z)) for z > 0.
double log_gamma(double z);

/// Returns the continued fraction of I_x(a, b) a B(a, b) / (x^a (1 - x)^b); quick for x < (a + 1) / (a + b + 2).
double beta_fraction(double a, double b, double x);

/// Returns I_x(a, b) for a, b > 0 and 0 <= x <= 1; relative error below 1e-11 for a and b up to 5,000.
double incomplete_beta(double a, double b, double x);

/// Returns P(F > f) of Fisher's distribution with these degrees of freedom, which need not be whole; f >= 0.
double f_tail(double f, double numerator, double denominator);
/// Returns the f with P(F > f) = `probability`, 0 < probability < 1.
double f_critical(double probability, double numerator, double denominator);

}  // namespace decid
