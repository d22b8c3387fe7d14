// Whether a recording follows the tilt as the identified controller would: a matched filter. Trials of the identified
// parameters, each with another vestibular noise, have the response to the tilt as their mean and noise about it;
// harmonic by harmonic the recording is laid over that mean, weighted by one over the noise's power. Method: Van Trees,
// Detection, Estimation, and Modulation Theory, Part I, ch. 4 (detection of a known signal in coloured noise).
#pragma once

#include <span>

#include "sim/fft.hpp"
#include "sim/simulate.hpp"

namespace decid {

/// `parameters`, which a network may put a little outside of what can be simulated, at the nearest that can.
sim::Parameters simulable(sim::Parameters parameters);

class Following {
 public:
  /// The simulator must outlive it. Throws Error if the trial's length has a prime factor above largest_fft_prime.
  explicit Following(const sim::Simulator& simulator);

  /// With Y the recording's spectrum, S the response's and N the noise's power at each line up to 2.5 Hz:
  ///   sum Re(Y conj S) / N  over  sum |S|^2 / N.
  /// 1: the response is there as expected; 0: it is not; below: it is reversed. Of 900 valid trials of the default
  /// protocol with 0.02 degrees of sensor noise, identified by the built-in model, 8% are below 0.3, as
  /// vestibular noise drowns the response; of the same started two or ten seconds late, 95%. NaN if the controller
  /// falls in most of its trials. sway_rad: the protocol's samples.
  double measure(const sim::Parameters& parameters, std::span<const float> sway_rad) const;

 private:
  std::vector<sim::Complex> spectrum(std::span<const double> sway_rad) const;

  const sim::Simulator& simulator_;
  sim::RealFft fft_;
  std::size_t lines_;
};

/// How little a recording is like what a model was trained on; above 1 its parameters are not to be trusted. Of the
/// distance of its features (familiarity.hpp) over what is usual, and of how little it follows the tilt: either alone
/// misses every sixth recording with a wrong start. The weights were chosen on 900 trials.
double unfamiliarity(double distance, double usual, double following);

}  // namespace decid
