// Where in a recording the protocol's stimulus starts, by the tilt that was measured with the sway.
// Not installed.
#pragma once

#include <span>
#include <vector>

namespace decid::dataset {

struct Match {
  double delay_samples = 0.0;  ///< `expected` starts there in `measured`; may be negative
  double correlation = 0.0;    ///< of the two at the nearest whole delay; negative: inverted
  double gain = 0.0;           ///< measured = gain * expected + constant, least squares
};

/// The delay of largest absolute normalised correlation, among those at which at most `overhang` samples of `expected`
/// lie outside of `measured` at either end; the earliest of those that are within 1e-6 of it, since a stimulus repeats.
/// Between samples by a parabola through the largest and its neighbours (Knapp and Carter, IEEE Trans. ASSP 24, 1976,
/// for the method; exact where the correlation is quadratic about its peak). measured: at least as long as expected
/// less the overhang; outside of it, its ends are held. Correlation 0 if either is constant.
Match match_tilt(std::span<const double> measured, std::span<const double> expected, int overhang);

}  // namespace decid::dataset
