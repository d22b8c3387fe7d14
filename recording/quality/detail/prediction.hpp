// How well the platform's tilt predicts a signal's next block of about 0.1 s, from the signal's last blocks:
//   y(t) = c + sum_i a_i y(t - i) + sum_j h_j u(t - j) + e(t)
// (ARX: L. Ljung, System Identification, 1999, section 4.2). The response may last longer than the taps h, as that of a
// body that hardly damps. Not installed.
#pragma once

#include <cstddef>
#include <vector>

namespace decid::recording {

inline constexpr std::size_t own_lags = 6, tilt_lags = 12;  ///< numbers of a and of h

struct Prediction {
  /// The number of blocks times the relative decrease of the squared error by h. Without a response about a chi-squared
  /// variable with 12 degrees of freedom. 0 for a signal that its own past determines, as a sine's does.
  double gain = 0.0;
  /// The further decrease if the tilt is read at times (1 + clock_error) t instead of t, to first order, beside a
  /// constant delay. For a right clock and a strong response about a chi-squared variable with one degree of freedom;
  /// larger by chance for a weak response, below a gain of some 60.
  double clock_gain = 0.0;
  /// Relative, positive for a clock that runs too slowly: the samples' true rate is the stated one over 1 +
  /// clock_error.
  double clock_error = 0.0;
};

/// signal: blocks' means about 0, not all 0. tilt: its element `first` is that of the signal's first block, and it has
/// 6 before this one.
Prediction predict(const std::vector<double>& signal, const std::vector<double>& tilt, std::size_t first);

}  // namespace decid::recording
