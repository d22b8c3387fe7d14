// Frequency response of the body's sway to the platform's tilt, measured at the harmonics of a periodic stimulus, with
// coherence and 95% confidence circles. Posturography: Peterka, J Neurophysiol 88, 2002. Estimator and circles:
// Pintelon and Schoukens, System Identification, 2nd ed. 2012, ch. 2, with the noise taken from lines beside the
// harmonics; the F distribution as in Bendat and Piersol, Random Data, 4th ed. 2010, ch. 9.
#pragma once

#include <span>
#include <vector>

#include "sim/fft.hpp"
#include "sim/parameters.hpp"
#include "sim/protocol/experiment.hpp"

namespace decid::sim {

/// One band: a harmonic, or neighbouring ones taken together.
struct FrfPoint {
  double frequency_hz = 0.0;  ///< mean of the harmonics' frequencies, weighted by the tilt's power in them
  int harmonics = 0;
  Complex response;        ///< rad/rad
  double radius = 0.0;     ///< the true response is within it of `response` with a probability of 95%; NaN: unknown
  double coherence = 0.0;  ///< 0..1; NaN: unknown
};

/// What of an experiment's trials is analysed, and how: immutable, one serves all threads.
///
/// The P cycles are transformed as one, so that harmonic k of the stimulus is line kP and all lines that the stimulus
/// leaves out hold noise alone. Harmonics up to 0.4 of the sample rate with 0.3% of the largest's amplitude
/// count as excited. Y, X: lines of sway and tilt; sums over the harmonics of a band, s2 the mean of |Y|^2 over up to
/// three such lines on either side of each harmonic.
///   response  = sum Y conj(X) / sum |X|^2
///   variance  = sum s2 |X|^2 / (sum |X|^2)^2
///   radius    = sqrt(variance F),   F the 95% quantile of F(2, nu), nu twice the number of noise lines
///   coherence = S / (S + P sum s2),   S = max(0, |response|^2 sum |X|^2 - variance sum |X|^2)
/// The coherence is that of a single cycle, corrected for its bias by the noise: near 0 on average for noise alone, and
/// never below 0. With one cycle the noise lines are harmonics that are not excited (a sequence whose second half is
/// the first negated has no even ones); where there are none, radius and coherence are unknown.
class FrequencyResponse {
 public:
  /// At most `bands_per_decade` bands in a decade; harmonics farther apart than that have a band each.
  /// The first `skipped_cycles` of a trial, with its transient from rest, are left out.
  /// Throws Error if the stimulus does not end a cycle where it started it, if its cycles are not a whole number of
  /// samples, if no cycle is left, or if their length has a prime factor above max_fft_prime.
  explicit FrequencyResponse(const Experiment& experiment, int skipped_cycles = 0, double bands_per_decade = 10.0);

  int cycles() const noexcept { return cycles_; }
  double cycle_s() const noexcept { return cycle_s_; }
  std::size_t bands() const noexcept { return bands_.size(); }

  /// sway_rad, tilt_rad: the protocol's samples, at least up to the end of its cycles. Throws Error if there are fewer.
  /// A measured tilt takes the place of the prescribed one, which still decides on harmonics and bands.
  std::vector<FrfPoint> measure(std::span<const float> sway_rad, std::span<const float> tilt_rad) const;
  /// closed_loop() averaged over each band as a measured response is: for theta = 0.
  std::vector<Complex> linear(const Parameters& parameters, const Body& body) const;

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
  std::size_t first_ = 0;  // sample
  RealFft fft_;
  std::vector<Band> bands_;
};

}  // namespace decid::sim
