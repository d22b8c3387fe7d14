// Frequency response of the body's sway to the platform's tilt, measured at the harmonics of a periodic stimulus, with
// coherence and 95% confidence circles. Posturography: Peterka, J Neurophysiol 88, 2002. Estimator and circles:
// Pintelon and Schoukens, System Identification, 2nd ed. 2012, ch. 2, with the noise from lines next to the harmonics.
// The F distribution is that of Bendat and Piersol, Random Data, 4th ed. 2010, ch. 9.
#pragma once

#include <span>
#include <vector>

#include "sim/fft.hpp"
#include "sim/parameters.hpp"
#include "sim/protocol/experiment.hpp"

namespace decid::sim {

/// One band: a harmonic, or several neighbouring ones.
struct FrfPoint {
  double frequency_hz = 0.0;  ///< mean of the harmonics' frequencies, weighted by the tilt's power in them
  int harmonics = 0;
  Complex response;  ///< rad/rad
  /// The true response is within this distance of `response` with a probability of 95%; NaN: unknown.
  double radius = 0.0;
  double coherence = 0.0;  ///< 0..1; NaN: unknown
};

/// The analysis of an experiment's trials. Immutable: all threads may share it.
///
/// The P cycles are transformed as one. Harmonic k of the stimulus is then line kP, and all lines between the stimulus'
/// harmonics contain only noise. Harmonics up to 0.4 of the sample rate with at least 0.3% of the largest amplitude
/// count as excited. Y, X: lines of sway and tilt; sums over the harmonics of a band, s2 the mean of |Y|^2 over up to
/// three such lines on either side of each harmonic.
///   response  = sum Y conj(X) / sum |X|^2
///   variance  = sum s2 |X|^2 / (sum |X|^2)^2
///   radius    = sqrt(variance F),   F the 95% quantile of F(2, nu), nu twice the number of noise lines
///   coherence = S / (S + P sum s2),   S = max(0, |response|^2 sum |X|^2 - variance sum |X|^2)
/// The coherence is that of a single cycle, corrected for its bias by the noise: about 0 on average for pure noise, and
/// never below 0. With one cycle the noise lines are harmonics that are not excited (a sequence whose second half is
/// the negated first has no even ones). Without noise lines, radius and coherence are unknown.
class FrequencyResponse {
 public:
  /// Makes at most `bands_per_decade` bands per decade; harmonics farther apart have a band each. Skips the first
  /// `skipped_cycles` of a trial, with its transient from rest. Throws Error if the stimulus does not end a cycle where
  /// it started, if its cycles are not a whole number of samples, if no cycle is left, or if their length has a prime
  /// factor above max_fft_prime.
  explicit FrequencyResponse(const Experiment& experiment, int skipped_cycles = 0, double bands_per_decade = 10.0);

  int cycles() const noexcept { return cycles_; }
  double cycle_s() const noexcept { return cycle_s_; }
  std::size_t bands() const noexcept { return bands_.size(); }

  /// Measures the response. sway_rad, tilt_rad: the protocol's samples, at least up to the end of its cycles. Throws
  /// Error if there are fewer. A measured tilt replaces the prescribed one, which still defines harmonics and bands.
  std::vector<FrfPoint> measure(std::span<const float> sway_rad, std::span<const float> tilt_rad) const;
  /// Returns closed_loop() averaged over each band like a measured response: for theta = 0. start_s: of a recording
  /// after the protocol's start; its sway is early by as much, but the tilt of its analysis is the protocol's.
  std::vector<Complex> linear(const Experiment& experiment, const Parameters& parameters, double start_s = 0.0) const;

 private:
  struct Harmonic {
    int line;
    double frequency_hz, power;  // of the prescribed tilt
    std::vector<int> noise_lines;
  };
  using Band = std::vector<Harmonic>;

  std::vector<Complex> transform(std::span<const float> signal) const;

  int cycles_ = 0;
  double cycle_s_ = 0.0;
  std::size_t first_ = 0;  // first sample
  RealFft fft_;
  std::vector<Band> bands_;
};

}  // namespace decid::sim
