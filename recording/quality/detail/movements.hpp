// Looks for a movement that is not a standing body's: a stagger, a catch by the harness, a step to another place,
// settling. Not installed. A matched filter correlates the innovations of an autoregression with shapes of such
// movements that passed the same filter (G. L. Turin, IRE Trans. Inf. Theory 6, 1960).
#pragma once

#include <span>
#include <vector>

namespace decid::recording {

struct Movement {
  /// The correlation with its shape, in robust standard deviations of this shape's correlations at all places.
  double deviations = 0.0;
  double size = 0.0;                  ///< its largest value, in the unit of the noise; a step's height
  double begin_s = 0.0, end_s = 0.0;  ///< within the noise
  bool is_step = false;               ///< what follows stays at another level
};

/// Returns the most conspicuous movement; zeros if there is none. noise: one value every step_s seconds, without the
/// response to the tilt. a: n(t) = sum_i a[i] n(t - 1 - i) + e(t). is_measured: one for each value, or empty, which is
/// all of them.
Movement find_movement(std::span<const double> noise, std::span<const double> a, const std::vector<bool>& is_measured,
                       double step_s);

}  // namespace decid::recording
