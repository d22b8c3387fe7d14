// Stability of the family's closed loop, whose characteristic equation A(s) + exp(-s delay) B(s) = 0 has polynomials A
// and B. Without delay the roots of A + B decide. As the delay grows, pairs of roots cross the imaginary axis at the
// frequencies where |A(i w)| = |B(i w)|, each time in the same direction (Walton, Marshall, IEE Proceedings D 134,
// 1987). Counting them is exact: no delay is approximated.
#pragma once

#include <vector>

#include "sim/family.hpp"
#include "sim/protocol/experiment.hpp"

namespace decid::frf {

/// Returns whether the loop is stable, without dead band and noise. A loop with unit gains crosses at one delay, which
/// has a closed form.
bool is_stable(const sim::Body& body, const sim::Family& family, const sim::Coefficients& c);

/// The largest margins that are searched for.
inline constexpr double max_delay_margin_s = 1.0, max_gain_margin = 100.0;

/// How far a stable loop is from instability, each change alone. 0, 1 and 1 for an unstable loop.
struct StabilityMargins {
  bool stable = false;
  double delay_s = 0.0;    ///< added to the delay; at most max_delay_margin_s
  double gain_low = 1.0;   ///< factor of kp and kd down to which it is stable; 0: it is stable without them
  double gain_high = 1.0;  ///< factor of kp and kd up to which it is stable; at most max_gain_margin
};
/// Returns the nearest changes at which is_stable() changes, searched in steps of 0.5 ms and 2%.
StabilityMargins stability_margins(const sim::Body& body, const sim::Family& family, const sim::Coefficients& c);

/// Returns the number of roots with a positive real part of A(s) + exp(-s delay) B(s) = 0; coefficients from the
/// constant term upwards, of degrees 1 to 4. A's degree is at least B's. If the degrees are equal, A's leading
/// coefficient must be larger than B's in size, because otherwise any delay has infinitely many such roots.
int unstable_roots(const std::vector<double>& a, const std::vector<double>& b, double delay_s);

}  // namespace decid::frf
