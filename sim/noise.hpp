// The noises of a trial: vestibular noise with a specified power spectrum, and white sensor noise.
#pragma once

#include <span>
#include <vector>

#include "base/math/random.hpp"
#include "sim/fft.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::sim {

/// The harmonics of the noise's period that carry vestibular noise: k / period from low_hz to high_hz. An edge that is
/// meant to be a harmonic, as 1/121 Hz is, belongs to the band however it is rounded.
struct NoiseBand {
  int first, last;
};
/// Throws Error if there is none, unless the noise is silent (scale_deg 0): first > last then.
NoiseBand noise_band(const Protocol& protocol);

/// Standard deviation of the vestibular noise's velocity at Nv = 1, rad/s. Throws Error as noise_band does.
double noise_velocity_deviation(const Protocol& protocol);

/// Makes realisations of the vestibular noise of a protocol: independent Gaussian harmonics of its period T,
/// nu(t) = sum over k of a_k cos(2 pi k t / T) + b_k sin(2 pi k t / T), where a_k and b_k have the variance PSD(k/T)/T
/// for low <= k/T <= high and are zero elsewhere. As the band is narrow, `phases` short inverse FFTs make it, each of
/// the samples that are `phases` apart: shifting the signal by a sample turns harmonic k by k / period. The controller
/// uses only the noise's velocity; that is what is made, to be linearly interpolated between the samples. Interpolation
/// multiplies the spectrum by sinc^2(f / rate), so the harmonics are divided by that: the interpolated velocity is
/// exact inside the band.
class VestibularNoiseMaker {
 public:
  /// The protocol must be valid. Throws Error as noise_band and RealFft do; a valid protocol makes neither throw.
  explicit VestibularNoiseMaker(const Protocol& protocol);

  /// rate[k] = d/dt nu at t = k / sample_rate, k = 0 .. samples of a trial, rad/s, divided by sinc^2. Harmonic k takes
  /// normals 2k and 2k + 1 of `random`. nv = 0: exactly zero. Throws Error unless `rate` holds samples + 1 values.
  void velocity(double nv, const Random& random, std::span<double> rate) const;
  /// The same for up to fft_lanes trials at once, each with the bits that it has alone: rate[k * fft_lanes + l] for
  /// trial l, in all (samples + 1) * fft_lanes values. A trial whose nv is 0, or that is not there, is exactly zero.
  void velocity_lanes(std::span<const double> nv, std::span<const Random> random, std::span<double> rate,
                      Isa isa = chosen_isa()) const;
  /// The noise itself at the same instants, rad; the same realisation.
  void angle(double nv, const Random& random, std::span<double> angle) const;

 private:
  /// One harmonic in the band. Deviations (standard, of cosine and sine) are those at Nv = 1.
  struct Harmonic {
    double angle_deviation;  // rad
    double rate_deviation;   // rad/s, divided by sinc^2(f / rate)
  };
  enum class Quantity { angle, velocity };
  void synthesize(Quantity quantity, double nv, const Random& random, std::span<double> out) const;
  /// The band's coefficients of one lane, into coefficients[(2 i + part) * lanes]; those of `lanes` lanes lie side by
  /// side.
  void draw(Quantity quantity, double nv, const Random& random, int lanes, double* coefficients) const;
  /// The transform's length: the shortest even divisor of `period` that resolves the band, or `period`.
  static int transform_length(int period, int last);

  int samples_, period_;             // of the trial, and until the noise repeats
  int first_;                        // number k of the band's lowest harmonic
  std::vector<Harmonic> harmonics_;  // first_, first_ + 1, ...
  RealFft fft_;
  int phases_;
  std::vector<Complex> turns_;  // of phase r and harmonic i: exp(2 pi i k r / period) at [r * harmonics + i]
};

/// The level of sensor noise of trial `item`, rad: log-uniform in the protocol's range, or 0 if that is 0.
double sensor_noise_level(const SensorNoise& noise, std::uint64_t seed, std::uint64_t item);
/// Adds that trial's sensor noise to its sway.
void add_sensor_noise(const SensorNoise& noise, std::uint64_t seed, std::uint64_t item, std::span<double> sway_rad);

}  // namespace decid::sim
