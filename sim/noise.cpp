// The noises of a trial: see noise.hpp.
// Vestibular: Gaussian harmonics with the power PSD(f) df each, df = 1 / T (Rice, Bell System Tech. J. 23, 1944).
// Sensor: white and Gaussian, its level log-uniform over the trials.
#include "sim/noise.hpp"

#include <cmath>
#include <string>

#include "base/error.hpp"
#include "base/math.hpp"

namespace decid::sim {
namespace {

double power_of(double base, double exponent) {
  return exponent == 1.0 ? base : decid::exp(exponent * decid::log(base));
}

}  // namespace

VestibularNoiseMaker::VestibularNoiseMaker(const Protocol& protocol)
    : samples_(protocol.samples()), fft_(protocol.samples()) {
  const VestibularNoise& noise = protocol.vestibular_noise;
  const double duration_s = protocol.duration_s();
  // A band edge that is meant to be a harmonic, as 1/121 Hz is, belongs to the band whatever its rounding.
  constexpr double slack = 1e-9;
  first_ = static_cast<int>(std::ceil(noise.low_hz * duration_s - slack));
  const int last = static_cast<int>(std::floor(noise.high_hz * duration_s + slack));
  if (noise.scale_deg == 0.0) return;
  if (first_ > last) {
    throw Error("protocol " + protocol.name + ", vestibular_noise",
                "no harmonic of the trial lies between low_hz and high_hz",
                "widen the band to hold a multiple of 1 / " + std::to_string(duration_s) + " Hz");
  }
  for (int k = first_; k <= last; ++k) {
    const double frequency_hz = k / duration_s;
    const double scale = noise.scale_deg * rad_per_deg;
    const double density = scale * scale / power_of(frequency_hz, noise.exponent);
    const double deviation = std::sqrt(density / duration_s);
    const double phase = pi * frequency_hz / protocol.sample_rate_hz;  // at most 0.1 pi
    const double sinc = sin_small(phase) / phase;
    harmonics_.push_back({deviation, deviation * (2.0 * pi * frequency_hz) / (sinc * sinc)});
  }
}

void VestibularNoiseMaker::velocity(double nv, const Random& random, std::span<double> rate) const {
  synthesize(Quantity::velocity, nv, random, rate);
}

void VestibularNoiseMaker::angle(double nv, const Random& random, std::span<double> angle) const {
  synthesize(Quantity::angle, nv, random, angle);
}

void VestibularNoiseMaker::synthesize(Quantity quantity, double nv, const Random& random, std::span<double> out) const {
  const auto samples = static_cast<std::size_t>(samples_);
  if (out.size() != samples + 1) {
    throw Error("vestibular noise", "the output holds " + std::to_string(out.size()) + " values",
                "make room for the trial's samples and one more, " + std::to_string(samples + 1));
  }
  std::vector<double> normals(2 * harmonics_.size());
  random.fill_normal(normals, 2 * static_cast<std::uint64_t>(first_));
  std::vector<Complex> spectrum(static_cast<std::size_t>(fft_.bins()));
  // a cos + b sin is the inverse transform of (a - i b) N / 2; its derivative is 2 pi f (b cos - a sin).
  const double gain = nv * (0.5 * samples_);
  for (std::size_t i = 0; i < harmonics_.size(); ++i) {
    const bool is_angle = quantity == Quantity::angle;
    const double deviation = gain * (is_angle ? harmonics_[i].angle_deviation : harmonics_[i].rate_deviation);
    const double a = deviation * normals[2 * i];
    const double b = deviation * normals[2 * i + 1];
    spectrum[static_cast<std::size_t>(first_) + i] = is_angle ? Complex(a, -b) : Complex(b, a);
  }
  std::vector<Complex> work(static_cast<std::size_t>(fft_.work_length()));
  fft_.inverse(spectrum, out.first(samples), work);
  out[samples] = out[0];
}

double sensor_noise_level(const SensorNoise& noise, std::uint64_t seed, std::uint64_t item) {
  if (noise.high_deg == 0.0) return 0.0;
  const double u = Random(seed, Stream::sensor_noise, item).uniform(0);
  return noise.low_deg * decid::exp(u * decid::log(noise.high_deg / noise.low_deg)) * rad_per_deg;
}

void add_sensor_noise(const SensorNoise& noise, std::uint64_t seed, std::uint64_t item, std::span<double> sway_rad) {
  const double level = sensor_noise_level(noise, seed, item);
  if (level == 0.0) return;
  std::vector<double> normals(sway_rad.size());
  Random(seed, Stream::sensor_noise, item).fill_normal(normals, 1);
  for (std::size_t k = 0; k < sway_rad.size(); ++k) sway_rad[k] += level * normals[k];
}

}  // namespace decid::sim
