// Groups of recordings compared by a parameter: means, deviations, and how large the difference is for its spread.
// Hedges' g with its 95 % interval: M. Borenstein, L. Hedges, J. Higgins, H. Rothstein, Introduction to Meta-Analysis,
// Wiley 2009, equations 4.18 to 4.24, after L. Hedges, J. Educ. Stat. 6 (1981) 107-128:
//   S^2 = ((n1 - 1) S1^2 + (n2 - 1) S2^2) / (n1 + n2 - 2)       d = (mean1 - mean2) / S
//   J = 1 - 3 / (4 (n1 + n2 - 2) - 1)                           g = J d
//   var g = J^2 ((n1 + n2) / (n1 n2) + d^2 / (2 (n1 + n2)))     g +- 1.96 sqrt(var g)
#pragma once

#include <cstddef>
#include <span>

namespace decid {

/// What is known of a group's values.
struct GroupSample {
  std::size_t count = 0;
  double mean = 0.0;
  double deviation = 0.0;  ///< with n - 1; NaN of fewer than two
};
GroupSample group_sample(std::span<const double> values);

struct GroupEffect {
  double difference = 0.0;       ///< of the means, first less second
  double g = 0.0;                ///< over the pooled deviation, without the bias of small groups
  double low = 0.0, high = 0.0;  ///< 95 % interval of g
};
/// g is NaN where a group has fewer than two values or neither varies.
GroupEffect group_effect(const GroupSample& first, const GroupSample& second);

}  // namespace decid
