// Whether a recording follows the tilt as the identified controller would: a matched filter. Trials of the identified
// parameters, each with another vestibular noise, have the response to the tilt as their mean and noise about it;
// harmonic by harmonic the recording is laid over that mean, weighted by one over the noise's power. Method: Van Trees,
// Detection, Estimation, and Modulation Theory, Part I, ch. 4 (detection of a known signal in coloured noise).
#pragma once

#include <array>
#include <span>
#include <vector>

#include "sim/fft.hpp"
#include "sim/simulate.hpp"

namespace decid {

/// The plan for one protocol: immutable, so one serves all threads.
class ResponseRatio {
 public:
  /// How many trials are simulated for a measurement: number i has the noise Random(0, Stream::vestibular_noise, i).
  static constexpr int trials = 32;

  /// Throws Error if the trial's length has a prime factor above max_fft_prime.
  explicit ResponseRatio(const sim::Protocol& protocol);

  /// The sways of those trials.
  class Simulated {
   public:
    /// A valid trial's sway; different trials may come from different threads. Trials that fell are left out.
    void put(int trial, std::span<const double> sway_rad);

   private:
    friend class ResponseRatio;
    std::array<std::vector<double>, trials> sways_;  // empty: it fell
  };

  /// With Y the recording's spectrum, S the response's and N the noise's power at each line up to 2.5 Hz:
  ///   sum Re(Y conj S) / N  over  sum |S|^2 / N.
  /// 1: the response is there as expected; 0: it is not; below: it is reversed. Of 900 valid trials of the default
  /// protocol with 0.02 degrees of sensor noise, identified by models/ideal.safetensors, 8% are below 0.3, as
  /// vestibular noise drowns the response; of the same ones started two or ten seconds late, 95%. NaN if the controller
  /// falls in most of its trials; without any noise, its own (Nv 0) and the sensor's, it may be: N is 0, but for
  /// rounding. sway_rad: the protocol's samples.
  /// spread: if it is given, what that is among trials of the controller with the sensor's noise. Its mean is below 1
  /// where noise drowns the response: S is the mean of some trials, so |S|^2 has their noise over their number in it.
  struct Spread {
    double mean = 1.0, sd = 0.0;
  };
  double measure(const Simulated& simulated, std::span<const float> sway_rad, Spread* spread = nullptr) const;

 private:
  sim::RealFft fft_;
  std::size_t lines_;
};

/// How little a recording is like what a model was trained on; above 1 its parameters are not to be trusted. It
/// combines the distance of its features (familiarity.hpp) over what is usual with how little it follows the tilt:
/// either alone misses every sixth recording with a wrong start. The weights were chosen on 900 trials.
double ood_score(double distance, double usual, double following);

}  // namespace decid
