// Reliability of repeated visits, from a two-way table of participants and visits: P. Shrout, J. Fleiss, Psychol. Bull.
// 86 (1979) 420-428; K. McGraw, S. Wong, Psychol. Methods 1 (1996) 30-46 (intervals); R's irr::icc(model = "twoway",
// type = "agreement") has the same values, for units "single" and "average". MSR, MSC, MSE: mean squares of n
// participants, k visits, and the rest.
//   ICC(2,1) = (MSR - MSE) / (MSR + (k - 1) MSE + k (MSC - MSE) / n)    one visit of a person
//   ICC(2,k) = (MSR - MSE) / (MSR + (MSC - MSE) / n)                    the mean of all k
// irr takes the degrees of freedom of each interval at its own ICC. For ICC(2,k) irr uses k times McGraw and Wong's a,
// ICC / (n (1 - ICC)). R's psych::ICC steps the interval of ICC(2,1) up by Spearman and Brown's formula instead, which
// gives slightly other ends for ICC(2,k).
//   standard error of measurement: root of MSE + max(0, MSC - MSE) / n, which counts that visits differ for everybody
//   minimal detectable change = 1.96 sqrt(2) standard errors (J. Weir, J. Strength Cond. Res. 19 (2005) 231-240)
// The rest is partly the recording's own uncertainty, which a posterior states, and partly the person's. The mean of a
// posterior of variance v under a prior of variance w shows 1 - v / w of a change, and varies by v (1 - v / w) for one
// person: exact for Gaussians.
#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace decid::cohort {

struct Reliability {
  std::size_t participants = 0;
  double icc_single = 0.0, icc_average = 0.0;  ///< ICC(2,1) and ICC(2,k)
  /// NaN if everybody changes by the same amount between visits, which does not determine them, or if the estimate lies
  /// outside (two people with an ICC below 0). ICC(2,k) and the ends of its interval are minus infinity where their
  /// denominator, the estimated variance of a person's mean, is 0 or below: the quotient would exceed 1. The JSON has
  /// null for both.
  std::array<double, 2> icc_single95{}, icc_average95{};
  double standard_error = 0.0;             ///< of measurement
  double minimal_detectable_change = 0.0;  ///< with 95%
  double participant_sd = 0.0;             ///< between participants
  double visit_sd = 0.0;                   ///< between visits, of everybody alike
  double measurement_sd = 0.0;             ///< the posteriors' part of the root of MSE
  double within_participant_sd = 0.0;      ///< the other part: root of MSE - measurement_sd^2, or 0
  /// The part of a person's change that the values show: means of posteriors are drawn towards the prior's mean. 1
  /// unless compute_reliability() sets it. A change of minimal_detectable_change / shown_fraction is detected.
  double shown_fraction = 1.0;
};

/// Computes the reliability. values: person by person, all visits each. measurement_variances: of the values, in their
/// order; empty: unknown, as if 0. Throws Error for fewer than two participants or visits, another number of values,
/// values that are not finite, and values without any variance.
Reliability reliability(std::size_t visits, std::span<const double> values,
                        std::span<const double> measurement_variances = {});

}  // namespace decid::cohort
