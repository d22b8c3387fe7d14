// Finds the start of the protocol's stimulus in a recording, by the tilt measured with the sway.
// Not installed.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

namespace decid::recording {

struct Match {
  double delay_samples = 0.0;  ///< start of `expected` in `measured`; may be negative
  double correlation = 0.0;    ///< at the nearest whole delay; negative: inverted
  double gain = 0.0;           ///< measured = gain * expected + constant, least squares
};

/// Searches many signals for one tilt: computes its spectrum once per transform length. All threads may share it.
class TiltMatcher {
 public:
  TiltMatcher(std::vector<double> expected, int overhang);
  ~TiltMatcher();

  /// Returns the delay of the largest absolute normalised correlation at which at most `overhang` samples of `expected`
  /// lie outside of `measured` at either end; of the largest positive one if it is within 0.01 of that, because the
  /// second half of many stimuli is their first half inverted. Among delays within 1e-6 of the maximum the earliest
  /// wins, because a stimulus repeats. A parabola through the maximum and its neighbours gives the delay between
  /// samples (Knapp and Carter, IEEE Trans. ASSP 24, 1976; exact where the correlation is quadratic about its peak).
  /// `measured` must be at least as long as `expected` minus the overhang; outside of it, its first and last value
  /// continue. The correlation is 0 if either signal is constant.
  Match match(std::span<const double> measured) const;

 private:
  struct Spectrum;
  const Spectrum& spectrum(std::size_t min_length) const;

  std::vector<double> expected_;  // without its mean
  std::size_t overhang_;
  double energy_ = 0.0, size_ = 0.0;  // sums of squares, without and with the mean
  mutable std::mutex mutex_;
  mutable std::map<int, std::unique_ptr<const Spectrum>>
      spectra_;  // by the transform's length; entries are never removed
};

}  // namespace decid::recording
