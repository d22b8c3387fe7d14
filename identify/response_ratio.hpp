// Stimulus response ratio: how much of the identified controller's response to the tilt a recording has. It is a
// matched filter. Trials of the identified parameters, each with different vestibular noise, have the response to the
// tilt as their mean and noise about it. The recording is projected onto that mean, harmonic by harmonic, weighted by
// one over the noise power. Method: Van Trees, Detection, Estimation, and Modulation Theory, Part I, ch. 4 (detection
// of a known signal in coloured noise).
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
  /// Number of trials simulated for a measurement; trial i has the noise Random(0, sim::streams::vestibular_noise, i).
  static constexpr int trials = 32;

  /// Throws Error if the trial's length has a prime factor above max_fft_prime.
  explicit ResponseRatio(const sim::Protocol& protocol);

  /// The sways of those trials.
  class Simulated {
   public:
    /// Stores a valid trial's sway; several threads may store different trials at once. Trials that fell are left out.
    void put(int trial, std::span<const double> sway_rad);

   private:
    friend class ResponseRatio;
    std::array<std::vector<double>, trials> sways_;  // empty: it fell
  };

  /// Computes the ratio. With Y the recording's spectrum, S the response's and N the noise's power at each line up to
  /// 2.5 Hz:
  ///   sum Re(Y conj S) / N  over  sum |S|^2 / N.
  /// 1: the response is there as expected; 0: it is not; below: it is reversed. The test set is 900 valid trials of the
  /// default protocol with 0.02° of measurement noise, identified by models/ideal.safetensors. 8% of them are below
  /// 0.3, because vestibular noise drowns the response; started two or ten seconds late, 95% are. NaN if the controller
  /// falls in most of its trials. NaN is possible without vestibular noise (Nv 0) and measurement noise: N is then 0 up
  /// to rounding. sway_rad: the protocol's samples. spread: unless null, gets the mean and standard deviation of the
  /// ratio over trials of the controller with measurement noise. The mean is below 1 if noise drowns the response: S is
  /// the mean of some trials, so |S|^2 contains their noise power over their number.
  struct Spread {
    double mean = 1.0, sd = 0.0;
  };
  double measure(const Simulated& simulated, std::span<const float> sway_rad, Spread* spread = nullptr) const;

 private:
  /// Returns the spectra of the trials, [line][trial]; 0 for trials that fell.
  std::vector<sim::Complex> spectra(const Simulated& simulated) const;

  sim::RealFft fft_;
  std::size_t lines_;
};

/// The score of a feature distance over the usual one, x, and the missing part of the response, m from 0 to 1, is
/// (x + ood_missing_weight m) / ood_border.
inline constexpr double ood_missing_weight = 0.4, ood_border = 1.17;

/// Returns the out-of-distribution score of a recording; above 1 its parameters are not reliable. The score combines
/// the feature distance (network/ood_detector.hpp), over the usual distance, with a low response ratio. Either term on
/// its own misses every sixth recording with a wrong start. The weights were chosen on 900 trials.
double ood_score(double distance, double usual, double response_ratio);

}  // namespace decid
