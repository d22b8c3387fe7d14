// Where in a recording the protocol's stimulus starts, by the tilt that was measured with the sway.
// Not installed.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

namespace decid::recording {

struct Match {
  double delay_samples = 0.0;  ///< `expected` starts there in `measured`; may be negative
  double correlation = 0.0;    ///< of the two at the nearest whole delay; negative: inverted
  double gain = 0.0;           ///< measured = gain * expected + constant, least squares
};

/// A tilt that is looked for in many others: its spectrum is made once for each length of the transforms. One serves
/// all threads.
class TiltMatcher {
 public:
  TiltMatcher(std::vector<double> expected, int overhang);
  ~TiltMatcher();

  /// The delay of largest absolute normalised correlation, among those at which at most `overhang` samples of
  /// `expected` lie outside of `measured` at either end; the earliest of those that are within 1e-6 of it, since a
  /// stimulus repeats. Between samples by a parabola through the largest and its neighbours (Knapp and Carter, IEEE
  /// Trans. ASSP 24, 1976, for the method; exact where the correlation is quadratic about its peak). measured: at least
  /// as long as expected less the overhang; outside of it, its ends are held. Correlation 0 if either is constant.
  Match match(std::span<const double> measured) const;

 private:
  struct Spectrum;
  const Spectrum& spectrum(std::size_t min_length) const;

  std::vector<double> expected_;  // its mean taken off
  std::size_t overhang_;
  double energy_ = 0.0, size_ = 0.0;  // sums of squares, without and with the mean
  mutable std::mutex mutex_;
  mutable std::map<int, std::unique_ptr<const Spectrum>> spectra_;  // by the transform's length; none is ever taken out
};

}  // namespace decid::recording
