// The noises of a trial: see noise.hpp.
// Vestibular noise: Gaussian harmonics with the power PSD(f) df each, df = 1 / T (Rice, Bell System Tech. J. 23, 1944).
// Measurement noise: white and Gaussian, with a level that is log-uniform over the trials.
#include "sim/noise.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "sim/kernels/generic_fft.hpp"
#include "sim/kernels/kernels.hpp"
#include "sim/protocol/detail/checker.hpp"
#include "sim/streams.hpp"

namespace decid::sim {
namespace {

double power_of(double base, double exponent) {
  return exponent == 1.0 ? base : decid::exp(exponent * decid::log(base));
}

constexpr double slack = 1e-9;  // of a harmonic's number

/// Returns the standard deviation of a harmonic's cosine and sine at Nv = 1, rad.
double angle_stddev(const VestibularNoise& noise, double frequency_hz, double period_s) {
  const double scale = noise.scale_deg * rad_per_deg;
  const double density = scale * scale / power_of(frequency_hz, noise.exponent);
  return std::sqrt(density / period_s);
}

}  // namespace

NoiseBand noise_band(const Protocol& protocol) {
  const VestibularNoise& noise = protocol.noise.vestibular;
  const double period_s = protocol.noise_period_samples() / protocol.experiment.sample_rate_hz;
  const NoiseBand band{static_cast<int>(std::ceil(noise.low_hz * period_s - slack)),
                       static_cast<int>(std::floor(noise.high_hz * period_s + slack))};
  if (band.first <= band.last || noise.scale_deg == 0.0) return band;
  throw Error(Code::setting_out_of_range, "protocol " + protocol.name + ", vestibular_noise",
              "no harmonic of the noise's period lies between low_hz and high_hz",
              "widen the band to contain a multiple of " + setting_text(1.0 / period_s) + " Hz, 1 / " +
                  setting_text(period_s) + " s");
}

double noise_velocity_stddev(const Protocol& protocol) {
  const NoiseBand band = noise_band(protocol);
  const double period_s = protocol.noise_period_samples() / protocol.experiment.sample_rate_hz;
  double variance = 0.0;
  for (int k = band.first; k <= band.last; ++k) {
    const double frequency_hz = k / period_s;
    const double stddev = 2.0 * pi * frequency_hz * angle_stddev(protocol.noise.vestibular, frequency_hz, period_s);
    variance += stddev * stddev;
  }
  return std::sqrt(variance);
}

int VestibularNoiseMaker::transform_length(int period, int last) {
  for (int length = 2 * last + 2; length < period; length += 2) {
    if (period % length == 0) return length;
  }
  return period;
}

VestibularNoiseMaker::VestibularNoiseMaker(const Protocol& protocol)
    : samples_(protocol.samples()),
      period_(protocol.noise_period_samples()),
      first_(noise_band(protocol).first),
      fft_(transform_length(period_, noise_band(protocol).last)),
      phases_(period_ / fft_.length()) {
  const VestibularNoise& noise = protocol.noise.vestibular;
  const double period_s = period_ / protocol.experiment.sample_rate_hz;
  const int last = noise_band(protocol).last;
  if (noise.scale_deg == 0.0) return;
  for (int k = first_; k <= last; ++k) {
    const double frequency_hz = k / period_s;
    const double stddev = angle_stddev(noise, frequency_hz, period_s);
    const double phase = pi * frequency_hz / protocol.experiment.sample_rate_hz;  // at most 0.1 pi
    const double sinc = sin_small(phase) / phase;
    stddev_.push_back(stddev * (2.0 * pi * frequency_hz) / (sinc * sinc));
  }
  for (int r = 0; r < phases_; ++r) {
    for (int k = first_; k <= last; ++k) {
      const auto [sin, cos] = sincos_of_turn(static_cast<long long>(k) * r, period_);
      turns_.emplace_back(cos, sin);
    }
  }
}

void VestibularNoiseMaker::draw(double nv, const Random& random, int lanes, double* coefficients) const {
  std::vector<double> normals(2 * stddev_.size());
  random.fill_normal(normals, 2 * static_cast<std::uint64_t>(first_));
  // a cos + b sin is the inverse transform of (a - i b) N / 2; the derivative is 2 pi f (b cos - a sin).
  const double gain = nv * (0.5 * fft_.length());
  const auto apart = static_cast<std::size_t>(lanes);
  for (std::size_t i = 0; i < stddev_.size(); ++i) {
    const double stddev = gain * stddev_[i];
    coefficients[2 * i * apart] = stddev * normals[2 * i + 1];
    coefficients[(2 * i + 1) * apart] = stddev * normals[2 * i];
  }
}

void VestibularNoiseMaker::velocity(double nv, const Random& random, std::span<double> rate) const {
  const auto samples = static_cast<std::size_t>(samples_);
  if (rate.size() != samples + 1) {
    throw Error(Code::size_mismatch, "vestibular noise",
                "the output has space for " + std::to_string(rate.size()) + " values",
                "give space for the trial's samples and one more, " + std::to_string(samples + 1));
  }
  const auto length = static_cast<std::size_t>(fft_.length()), phases = static_cast<std::size_t>(phases_);
  std::vector<double> coefficients(2 * stddev_.size()), signal(length);
  draw(nv, random, 1, coefficients.data());
  std::vector<Complex> spectrum(static_cast<std::size_t>(fft_.bins()));
  std::vector<Complex> work(static_cast<std::size_t>(fft_.work_length()));
  // A long period has more phases than the trial has samples.
  for (std::size_t r = 0; r < std::min(phases, samples + 1); ++r) {
    turn<One, 1>(static_cast<int>(stddev_.size()), coefficients.data(),
                 reinterpret_cast<const double*>(turns_.data() + r * stddev_.size()),
                 reinterpret_cast<double*>(spectrum.data() + first_));
    fft_.inverse(spectrum, signal, work);
    const std::size_t count = std::min(length, (samples - r) / phases + 1);
    for (std::size_t m = 0; m < count; ++m) rate[m * phases + r] = signal[m];
  }
  if (period_ == samples_) rate[samples] = rate[0];
}

void VestibularNoiseMaker::velocity_lanes(std::span<const double> nv, std::span<const Random> random,
                                          std::span<double> rate, Isa isa) const {
  constexpr std::size_t lanes = fft_lanes;
  const auto samples = static_cast<std::size_t>(samples_);
  if (nv.size() > lanes || random.size() != nv.size() || rate.size() != (samples + 1) * lanes) {
    throw Error(Code::size_mismatch, "vestibular noise",
                "got " + std::to_string(nv.size()) + " trials and space for " + std::to_string(rate.size()) + " values",
                "give at most 8 trials, and space for " + std::to_string((samples + 1) * lanes));
  }
  const auto length = static_cast<std::size_t>(fft_.length()), phases = static_cast<std::size_t>(phases_);
  const FftKernels& kernels = simulator_kernels(isa).fft;
  std::vector<double> coefficients(2 * stddev_.size() * lanes, 0.0), signal(length * lanes);
  std::vector<double> spectrum(2 * static_cast<std::size_t>(fft_.bins()) * lanes, 0.0);
  std::vector<double> work(2 * static_cast<std::size_t>(fft_.work_length()) * lanes);
  for (std::size_t lane = 0; lane < nv.size(); ++lane) {
    if (nv[lane] > 0.0 && !stddev_.empty()) draw(nv[lane], random[lane], fft_lanes, coefficients.data() + lane);
  }
  // A long period has more phases than the trial has samples.
  for (std::size_t r = 0; r < std::min(phases, samples + 1); ++r) {
    kernels.turn(static_cast<int>(stddev_.size()), coefficients.data(),
                 reinterpret_cast<const double*>(turns_.data() + r * stddev_.size()),
                 spectrum.data() + 2 * static_cast<std::size_t>(first_) * lanes);
    fft_.inverse_lanes(spectrum, signal, work, isa);
    const std::size_t count = std::min(length, (samples - r) / phases + 1);
    for (std::size_t m = 0; m < count; ++m)
      std::copy_n(signal.data() + m * lanes, lanes, rate.data() + (m * phases + r) * lanes);
  }
  if (period_ == samples_) std::copy_n(rate.data(), lanes, rate.data() + samples * lanes);
}

double sensor_noise_level(const SensorNoise& noise, std::uint64_t seed, std::uint64_t item) {
  if (noise.high_deg == 0.0) return 0.0;
  const double u = Random(seed, streams::sensor_noise, item).uniform(0);
  return noise.low_deg * decid::exp(u * decid::log(noise.high_deg / noise.low_deg)) * rad_per_deg;
}

void add_sensor_noise(const SensorNoise& noise, std::uint64_t seed, std::uint64_t item, std::span<double> sway_rad) {
  const double level = sensor_noise_level(noise, seed, item);
  if (level == 0.0) return;
  std::vector<double> normals(sway_rad.size());
  Random(seed, streams::sensor_noise, item).fill_normal(normals, 1);
  for (std::size_t k = 0; k < sway_rad.size(); ++k) sway_rad[k] += level * normals[k];
}

}  // namespace decid::sim
