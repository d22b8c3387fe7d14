// The noises of a trial: vestibular noise with a specified power spectrum, and white sensor noise.
#pragma once

#include <span>
#include <vector>

#include "base/random.hpp"
#include "sim/fft.hpp"
#include "sim/protocol.hpp"

namespace decid::sim {

/// Makes realisations of the vestibular noise of a protocol: independent Gaussian harmonics of the trial's length T,
/// variance PSD(k/T)/T each, for low <= k/T <= high, by an inverse real FFT.
/// The controller uses only the noise's velocity; that is what is made, linearly interpolated between the samples,
/// its harmonics divided by sinc^2(f/rate) so that the interpolated spectrum is exact inside the band.
class VestibularNoiseMaker {
 public:
  explicit VestibularNoiseMaker(const Protocol& protocol);

  /// rate[k] = d/dt nu at t = k / sample_rate, k = 0 .. samples (the trial is periodic: rate[samples] = rate[0]),
  /// rad/s. Harmonic k takes normals 2k and 2k + 1 of `random`.
  void velocity(double nv, const Random& random, std::span<double> rate) const;
  /// The noise itself at the same instants, rad; the same realisation.
  void angle(double nv, const Random& random, std::span<double> angle) const;

 private:
  void synthesize(double nv, const Random& random, bool velocity, std::span<double> out) const;

  int samples_;
  int first_, last_;                    // harmonics in the band
  double base_hz_;                      // 1 / T
  std::vector<double> angle_deviation_;  // standard deviation of a harmonic's cosine and sine, at Nv = 1, rad
  std::vector<double> rate_factor_;      // 2 pi f / sinc^2(f / rate)
  RealFft fft_;
};

/// The level of sensor noise of trial `item`, rad: log-uniform in the protocol's range.
double sensor_noise_level(const SensorNoise& noise, std::uint64_t seed, std::uint64_t item);
/// Adds that trial's sensor noise to its sway.
void add_sensor_noise(const SensorNoise& noise, std::uint64_t seed, std::uint64_t item, std::span<double> sway_rad);

}  // namespace decid::sim
