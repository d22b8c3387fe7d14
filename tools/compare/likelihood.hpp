// Likelihood of a recording under a set of parameters. It compares the recording's spectrum, frequency by frequency,
// with spectra of trials simulated with several realisations of the noise (Whittle, J Roy Stat Soc B 15, 1953, with
// moments from simulation: synthetic likelihood, Wood, Nature 466, 2010).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sim/fft.hpp"
#include "sim/simulate.hpp"
#include "tools/compare/streams.hpp"

namespace decid::iterative {

/// The frequencies of a trial that the fit uses. Blocks of samples are averaged to about 10 Hz; bin k is Y_k = 1/n sum
/// of y exp(-2 pi i k j / n) of the n blocks, frequency k / T, k = 1 .. bins(), up to 4 Hz. The mean is subtracted, as
/// recordings have an offset. A cosine taper over a tenth of the trial at either end removes what a drift from its
/// start to its end would add to every frequency, as the tilt estimate wanders. If the stimulus repeats, its harmonics
/// hold the response to it, all other bins the residual; no setting has to separate them.
class TrialSpectrum {
 public:
  static constexpr double highest_hz = 4.0;
  /// Throws Error if the trial has fewer than 20 bins below 4 Hz: it is too short.
  explicit TrialSpectrum(const sim::Protocol& protocol);

  int bins() const noexcept { return bins_; }
  /// sway_rad: a trial's samples; out: bins() values, rad. Safe to call from many threads.
  void of(std::span<const double> sway_rad, std::span<sim::Complex> out) const;

  /// First bin of each band and, at the end, bins() (bins counted from 0 here: bin 0 is k = 1). Within a band the
  /// residual's power is taken as constant: bands are a fifth of their frequency wide, at least 4 bins, and none
  /// holds an end of the vestibular noise's band.
  const std::vector<int>& bands() const noexcept { return bands_; }

 private:
  int samples_, block_, length_, bins_;
  double bin_hz_;
  sim::RealFft fft_;
  std::vector<double> taper_;
  std::vector<int> bands_;
};

/// A recording's cost at one set of parameters.
struct Cost {
  double value;             ///< minus the logarithm of the likelihood, up to a constant; finite even if the body falls
  double sensor_noise_deg;  ///< the white noise at which the recording is likeliest; 0 if the body falls
};

class Likelihood {
 public:
  /// sway_rad: the recording, one value for each of the simulator's samples. Throws Error if there are more or fewer,
  /// if one is not finite, and as TrialSpectrum does.
  Likelihood(const sim::Simulator& simulator, std::span<const float> sway_rad);

  /// The cost of each candidate, with `realisations` (at least 2) of the noise numbered from `first`: the same for all
  /// candidates, so that differences between them are not blurred by chance (common random numbers).
  ///
  /// With R realisations X_r, their mean M_k at bin k, and S_b the mean of |X_k - M_k|^2 R / (R - 1) over band b, the
  /// recording's Y_k is complex normal about M_k with variance V = S_b (1 + 1/R) + s^2 / samples. As S_b is itself
  /// estimated, with v = n_b (R - 1) complex degrees of freedom, the normal becomes Student's t:
  ///   cost = 1/2 sum over k of  log V + (v + 1) log(1 + |Y_k - M_k|^2 / (v V))
  /// The 1/2 is a temperature: the dead band makes the bins depend on each other, so that together they hold less
  /// information than the sum of each. Found on trials of a seed that no figure is quoted for: with 1/2 the squared
  /// errors were about twice the squared standard errors, with 1 four times, and the errors of the mean were larger.
  /// The measurement noise s is estimated: the likeliest of a list of levels from 0.0005° to 0.5°. If realisations
  /// fall, the cost uses the standing ones and adds - log(fraction that stands). With fewer than 2 or half of them
  /// standing, the cost is larger than any standing cost, and larger the earlier they fall. The cost depends neither on
  /// threads nor on the other candidates.
  std::vector<Cost> costs(std::span<const sim::Parameters> candidates, int realisations, std::uint64_t seed,
                          std::uint64_t first) const;

 private:
  Cost cost(std::span<const sim::Complex> simulated, std::span<const double> stood_s) const;

  sim::Simulator simulator_;
  TrialSpectrum spectrum_;
  std::vector<sim::Complex> recorded_;
};

}  // namespace decid::iterative
