// Student's t distribution, for intervals of differences between means; the same bits on every machine.
// The tails are an incomplete beta function: DLMF 8.17.22 (continued fraction) and 5.11.1 (Stirling's series).
#pragma once

namespace decid {

/// Returns P(|T| > t) for t >= 0 and `degrees_of_freedom` > 0 degrees of freedom, which need not be whole; relative
/// error below 1e-11 up to 10,000 degrees of freedom. NaN for NaN.
double student_t_tails(double t, double degrees_of_freedom);

/// Returns the t >= 0 with P(|T| > t) = `probability`, for 0 < probability <= 1: of a 95% interval,
/// student_t_critical(0.05, degrees_of_freedom) standard errors lie on each side.
double student_t_critical(double probability, double degrees_of_freedom);

}  // namespace decid
