// The noises of a trial: vestibular noise with a given power spectrum, and white measurement noise.
#pragma once

#include <span>
#include <vector>

#include "base/math/random.hpp"
#include "sim/fft.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::sim {

/// The harmonics of the noise's period that carry vestibular noise: k / period from low_hz to high_hz. A band edge
/// meant to be a harmonic, such as 1/121 Hz, belongs to the band in spite of rounding.
struct NoiseBand {
  int first, last;
};
/// Returns the band. Throws Error if it is empty, unless the noise is silent (scale_deg 0): then first > last.
NoiseBand noise_band(const Protocol& protocol);

/// Returns the standard deviation of the vestibular noise's velocity at Nv = 1, rad/s. Throws Error as noise_band does.
double noise_velocity_stddev(const Protocol& protocol);

/// Makes realisations of a protocol's vestibular noise: independent Gaussian harmonics of its period T, nu(t) = sum
/// over k of a_k cos(2 pi k t / T) + b_k sin(2 pi k t / T), where a_k and b_k have the variance PSD(k/T)/T for low <=
/// k/T <= high and are zero elsewhere. Because the band is narrow, `phases` short inverse FFTs suffice, each for the
/// samples that are `phases` apart: a shift by one sample rotates harmonic k by k / period. The controller uses only
/// the noise's velocity, linearly interpolated between samples. Interpolation multiplies the spectrum by sinc^2(f /
/// rate). The harmonics are divided by that, which makes the interpolated velocity exact inside the band.
class VestibularNoiseMaker {
 public:
  /// The protocol must be valid. Throws Error as noise_band and RealFft do; neither throws for a valid protocol.
  explicit VestibularNoiseMaker(const Protocol& protocol);

  /// Computes rate[k] = d/dt nu at t = k / sample_rate, k = 0 .. samples of a trial, rad/s, divided by sinc^2. Harmonic
  /// k takes normals 2k and 2k + 1 of `random`. nv = 0: exactly zero. Throws Error unless `rate` holds samples + 1
  /// values.
  void velocity(double nv, const Random& random, std::span<double> rate) const;
  /// Computes the same bits for up to fft_lanes trials at once: rate[k * fft_lanes + l] for trial l, (samples + 1) *
  /// fft_lanes values in total. A trial whose nv is 0, or that is missing, is exactly zero.
  void velocity_lanes(std::span<const double> nv, std::span<const Random> random, std::span<double> rate,
                      Isa isa = chosen_isa()) const;

 private:
  /// Draws the band's coefficients of one lane into coefficients[(2 i + part) * lanes]; `lanes` lanes are interleaved.
  void draw(double nv, const Random& random, int lanes, double* coefficients) const;
  /// Returns the transform's length: the shortest even divisor of `period` that resolves the band, or `period`.
  static int transform_length(int period, int last);

  int samples_, period_;  // of the trial, and of the noise
  int first_;             // number k of the band's lowest harmonic
  // Standard deviations of harmonics first_, first_ + 1, ... at Nv = 1: rad/s, divided by sinc^2(f / rate).
  std::vector<double> stddev_;
  RealFft fft_;
  int phases_;
  std::vector<Complex> turns_;  // for phase r and harmonic i: exp(2 pi i k r / period) at [r * harmonics + i]
};

/// Returns the measurement noise level of trial `item`, rad: log-uniform in the protocol's range, or 0 if that is 0.
double sensor_noise_level(const SensorNoise& noise, std::uint64_t seed, std::uint64_t item);
/// Adds that trial's measurement noise to its sway.
void add_sensor_noise(const SensorNoise& noise, std::uint64_t seed, std::uint64_t item, std::span<double> sway_rad);

}  // namespace decid::sim
