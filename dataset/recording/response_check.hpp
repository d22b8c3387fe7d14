// Whether a sway goes on as it began: its response to the platform's tilt, and what it does besides.
// Not installed. At about 10 Hz, u the tilt that the protocol prescribes:
//   y(t) = c + sum_j h_j u(t - j) + n(t),  n(t) = sum_i a_i n(t - i) + e(t),  by least squares in turn (D. Cochrane and
//   G. H. Orcutt, J. Am. Stat. Assoc. 44, 1949).
#pragma once

#include <span>
#include <vector>

#include "base/warning.hpp"

namespace decid::dataset {

/// A tilt that sways are checked against. Immutable: one serves all threads.
class ResponseCheck {
 public:
  /// tilt_rad: of the trial's samples.
  ResponseCheck(std::span<const double> tilt_rad, double rate_hz);

  struct Found {
    double innovation_rad = 0.0, medians = 0.0;  ///< the largest |e|, and how many medians of |e| that is
    double innovation_at_s = 0.0;
    /// How much better the fit is if from slip_at_s on the sway is slip_s earlier than the tilt (a stretch is missing),
    /// or later: samples times the residual's loss, over the residual. 0 if none is better.
    double slip_gain = 0.0, slip_s = 0.0, slip_at_s = 0.0;
  };
  /// Of a sway with the tilt's samples. All 0 for trials under 40 s.
  Found check(std::span<const double> sway_rad) const;

 private:
  std::size_t block_;
  double step_s_;
  std::vector<double> tilt_;  // means of blocks, with rest before and after
  std::size_t blocks_;        // of the trial
};

/// Adds `stretch_off`, if sway moves as such a sway does not: 0.3 degrees and 14 medians; and `time_slips`. Cautions.
/// Nothing is added of sways whose jumps or single wrong samples have been found.
void look_for_changes(const ResponseCheck& check, std::span<const double> sway_rad, Warnings& warnings);

}  // namespace decid::dataset
