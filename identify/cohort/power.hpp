// Power of a study, before it is made: the probability that the 95% interval of a difference leaves out 0.
//   variance of a person's mean:  person^2 + (trial^2 + measurement^2) / trials
//   two groups of n:  noncentrality difference / sqrt(2 variance / n), 2 n - 2 degrees of freedom
//   pairs of n:       noncentrality difference / sqrt(2 (visit^2 + (trial^2 + measurement^2) / trials) / n), n - 1
// (J. Cohen, Statistical Power Analysis for the Behavioral Sciences, 1988, chapter 2.) Student's noncentral
// distribution is integrated over the standard deviation that the study finds.
#pragma once

#include <cstddef>

namespace decid::cohort {

/// A study of two groups, or of two visits of the same participants. Standard deviations have the unit of the
/// difference.
struct PowerDesign {
  std::size_t participants = 12;  ///< per group; pairs: in all
  std::size_t trials = 1;         ///< per person and visit
  bool paired = false;
  double participant_sd = 0.0;  ///< between participants; without effect on pairs
  double visit_sd = 0.0;        ///< of a person from visit to visit; of pairs
  double trial_sd = 0.0;        ///< of a person from trial to trial
  double measurement_sd = 0.0;  ///< of one recording
};

/// Returns the power for a difference of the means. Throws Error for fewer than two participants, no trial, standard
/// deviations that are negative, and a variance of 0.
double power_of(const PowerDesign& design, double difference, double significance = 0.05);

/// Returns the smallest number of participants with at least this power; 0: more than 10,000. Throws Error as
/// power_of(), and for a power outside of (0, 1).
std::size_t participants_for(PowerDesign design, double difference, double power, double significance = 0.05);

/// Returns the smallest number of trials per person with at least this power; 0: more than 1,000, or no number, where
/// people differ too much for so few participants. Throws Error as participants_for().
std::size_t trials_for(PowerDesign design, double difference, double power, double significance = 0.05);

}  // namespace decid::cohort
