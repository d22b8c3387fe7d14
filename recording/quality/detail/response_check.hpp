// Checks whether a sway continues as it began, by its linear response to the platform's tilt. Not installed. At about
// 10 Hz, with the prescribed tilt u:
//   y(t) = c + sum_j h_j u(t - j) + n(t),  n(t) = sum_i a_i n(t - i) + e(t),
// fitted alternately by least squares (D. Cochrane and G. H. Orcutt, J. Am. Stat. Assoc. 44, 1949).
#pragma once

#include <span>
#include <vector>

#include "base/sample_range.hpp"
#include "recording/quality/detail/movements.hpp"
#include "recording/quality/detail/prediction.hpp"

namespace decid::recording {

/// Checks sways against one tilt. Immutable: threads may share it.
class ResponseCheck {
 public:
  /// tilt_rad: one value per sample of the trial. has_passive: the body's passive stiffness or damping responds to the
  /// tilt at once; else only the active torque responds, after its delay.
  ResponseCheck(std::span<const double> tilt_rad, double rate_hz, bool has_passive = true);

  struct Found {
    double innovation_rad = 0.0, medians = 0.0;  ///< the largest |e|, and its ratio to the median of |e|
    double innovation_at_s = 0.0;
    Movement movement;  ///< the most conspicuous one, in rad
    /// The improvement if the sway from slip_at_s is slip_s earlier than before (positive: a stretch is missing).
    /// slip_gain is the number of samples times the relative decrease of the residual, or 0.
    double slip_gain = 0.0, slip_s = 0.0, slip_at_s = 0.0;
    double shift_gain = 0.0, shift_s = 0.0;  ///< the same improvement if the whole sway is shift_s earlier
    /// How much later than a body the sway begins to respond, so that the recording starts early; 0 below 0.3 s, or
    /// 0.5 s for a tilt of few sines, always for a single sine, and for a small response.
    double early_s = 0.0;
    /// The same improvement without any response from rest_begin_s to rest_end_s, one of which is an end of the trial.
    /// Below 0, thus 0, for a sway that follows the tilt throughout.
    double rest_gain = 0.0, rest_begin_s = 0.0, rest_end_s = 0.0;
  };
  /// Checks a sway that has the tilt's number of samples. Returns zeros for trials under 40 s, and gains of 0 for a
  /// tilt of a single sine. gaps: samples that were not measured; no movement is looked for there.
  Found check(std::span<const double> sway_rad, std::span<const SampleRange> gaps = {}) const;

  struct Response {
    double gain = 0.0;     ///< the improvement by the response to the tilt, as slip_gain; about 12 without a response
    double rms_rad = 0.0;  ///< of the response
  };
  /// Returns the response of a signal that has the tilt's number of samples and starts shift_s, -3 to 3, after it.
  /// Returns zeros for trials under 40 s, and for a constant.
  Response response_of(std::span<const double> signal_rad, double shift_s = 0.0) const;
  /// Returns how the tilt improves the prediction of a signal. Signal and shift_s as of response_of(); zeros as there.
  Prediction prediction_of(std::span<const double> signal_rad, double shift_s = 0.0) const;

 private:
  class Slips;            // fits in which the tilt is read later
  bool is_short() const;  ///< under 40 s or 300 blocks
  /// Returns the blocks' means of a signal, minus their mean; empty for a short trial, and for a constant.
  std::vector<double> centred_blocks(std::span<const double> signal_rad) const;
  /// Returns `rest` plus the blocks by which the tilt is read later.
  std::size_t shifted_by(double shift_s) const;
  void find_innovation(std::vector<double> innovations, Found& found) const;
  /// Sets the slip and the shift, or the rest, whose fits are better than `plain`, the residual without any.
  void find_slip(const Slips& slips, double plain, Found& found) const;
  void find_rest(const Slips& slips, double plain, Found& found) const;

  std::size_t block_;
  double step_s_;
  std::vector<double> tilt_;             // means of blocks, with rest before and after
  std::size_t blocks_;                   // of the trial
  std::size_t typical_dead_, max_dead_;  // blocks of a body's dead time
  bool is_sine_ = false;                 // a shift of the tilt is another response to it
  bool is_determined_ = false;           // the tilt's values determine its later ones, as those of few sines
};

}  // namespace decid::recording
