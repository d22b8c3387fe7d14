// Tests of sim/noise.hpp: the spectrum of many realisations, the interpolated velocity, the levels of sensor noise.
// Everything is a fixed function of the seed; statistical bounds are multiples of the estimate's standard error.
#include "sim/noise.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "sim/streams.hpp"
#include "tests/near.hpp"

using namespace decid::sim;
using decid::Random;
using decid::Stream;
using decid::test::near;

namespace {

// With noise whose harmonics are the trial's.
Protocol repeating(Protocol protocol = {}) {
  protocol.noise.vestibular.period_s = protocol.duration_s();
  return protocol;
}

// Returns what makes the interpolated velocity of a harmonic from its angle: 2 pi f / sinc^2(f / rate), 1/s.
double rate_per_angle(const Protocol& protocol, double frequency_hz) {
  const double phase = pi * frequency_hz / protocol.experiment.sample_rate_hz, sinc = std::sin(phase) / phase;
  return 2.0 * pi * frequency_hz / (sinc * sinc);
}

// Periodogram of the velocity, averaged over realisations: (rad/s)^2/Hz at k / T, one-sided.
std::vector<double> average_periodogram(const Protocol& protocol, double nv, int realisations) {
  const VestibularNoiseMaker maker(protocol);
  const int samples = protocol.samples();
  const RealFft fft(samples);
  std::vector<double> rate(static_cast<std::size_t>(samples) + 1);
  std::vector<Complex> spectrum(static_cast<std::size_t>(fft.bins()));
  std::vector<Complex> work(static_cast<std::size_t>(fft.work_length()));
  std::vector<double> density(spectrum.size());
  // A harmonic's power, |2 X / N|^2 / 2, lies in a band of 1 / T.
  const double density_per_square = 2.0 / samples / samples * protocol.duration_s() / realisations;
  for (int i = 0; i < realisations; ++i) {
    maker.velocity(nv, Random(5, streams::vestibular_noise, static_cast<std::uint64_t>(i)), rate);
    fft.forward(std::span(rate).first(static_cast<std::size_t>(samples)), spectrum, work);
    for (std::size_t k = 0; k < density.size(); ++k) density[k] += density_per_square * std::norm(spectrum[k]);
  }
  return density;
}

// Checks level, slope and band of a protocol's noise.
void check_spectrum(const Protocol& protocol, double nv, int first, int last) {
  constexpr int realisations = 600;
  const VestibularNoise& noise = protocol.noise.vestibular;
  const std::vector<double> density = average_periodogram(protocol, nv, realisations);
  const double duration = protocol.duration_s();
  double worst = 0.0, level = 0.0, outside = 0.0, largest = 0.0;
  // Least squares of log(density of the angle) on log(f).
  double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  for (int k = 0; k < static_cast<int>(density.size()); ++k) {
    const double value = density[static_cast<std::size_t>(k)];
    if (k < first || k > last) {
      outside = std::max(outside, value);
      continue;
    }
    const double frequency_hz = k / duration;
    const double angle = value / std::pow(rate_per_angle(protocol, frequency_hz), 2.0);
    const double expected = std::pow(nv * noise.scale_deg * rad_per_deg, 2.0) / std::pow(frequency_hz, noise.exponent);
    const double ratio = angle / expected, log_f = std::log(frequency_hz), log_value = std::log(angle);
    worst = std::max(worst, std::abs(ratio - 1.0));
    level += ratio / (last - first + 1);
    largest = std::max(largest, value);
    n += 1.0, x += log_f, y += log_value, xx += log_f * log_f, xy += log_f * log_value;
  }
  const double slope = (n * xy - x * y) / (n * xx - x * x);
  // A harmonic's power has 2 degrees of freedom, its standard error is its mean / sqrt(realisations).
  CHECK(worst < 4.5 / std::sqrt(realisations));
  CHECK(std::abs(level - 1.0) < 4.0 / std::sqrt(realisations * n));
  CHECK(std::abs(slope + noise.exponent) < 0.05);
  // Rounding errors of the two transforms: below 1e-15 of the root of the largest density, each.
  CHECK(outside < 1e-29 * largest);
}

}  // namespace

TEST_CASE("VestibularNoiseMaker: the default spectrum") {
  check_spectrum(repeating(), 1.0, 1, 121);  // 1/121 Hz .. 1 Hz
}

TEST_CASE("VestibularNoiseMaker: other bands, scales and exponents") {
  Protocol protocol = short_protocol();  // 63.7 s
  protocol.noise.vestibular = {.scale_deg = 0.5, .low_hz = 0.1, .high_hz = 10.0, .exponent = 1.0};
  check_spectrum(repeating(protocol), 0.3, 7, 637);
  protocol.noise.vestibular = {.scale_deg = 0.1, .low_hz = 0.01, .high_hz = 2.0, .exponent = 2.0};
  check_spectrum(repeating(protocol), 1.0, 1, 127);
  protocol.noise.vestibular.exponent = 0.0;
  check_spectrum(repeating(protocol), 2.0, 1, 127);
}

TEST_CASE("VestibularNoiseMaker: the velocity, interpolated, is the derivative of the angle") {
  for (const double rate_hz : {100.0, 20.0}) {
    Protocol protocol;
    protocol.experiment.sample_rate_hz = rate_hz;
    protocol.noise.vestibular.high_hz = rate_hz / 10.0;
    const VestibularNoiseMaker maker(repeating(protocol));
    const auto samples = static_cast<std::size_t>(protocol.samples());
    const Random random(2, streams::vestibular_noise, 4);
    std::vector<double> rate(samples + 1);
    maker.velocity(0.7, random, rate);
    CHECK(rate.back() == rate.front());

    std::vector<double> fine;  // on the 1 ms grid, as the simulation has it
    const auto per_sample = static_cast<std::size_t>(protocol.experiment.steps_per_sample());
    for (std::size_t j = 0; j < samples; ++j) {
      for (std::size_t i = 0; i < per_sample; ++i) {
        const double part = static_cast<double>(i) / static_cast<double>(per_sample);
        fine.push_back((1.0 - part) * rate[j] + part * rate[j + 1]);
      }
    }
    const RealFft fft(protocol.experiment.steps());
    std::vector<Complex> interpolated(static_cast<std::size_t>(fft.bins()));
    std::vector<Complex> work(static_cast<std::size_t>(fft.work_length()));
    fft.forward(fine, interpolated, work);
    double worst = 0.0;
    for (std::size_t k = 1; k <= static_cast<std::size_t>(121.0 * rate_hz / 10.0); ++k) {
      // The angle a cos + b sin, whose a and b are the normals 2k and 2k + 1 times this.
      const double stddev = 0.7 * 0.2 * rad_per_deg / std::sqrt(static_cast<double>(k));
      const Complex angle = stddev * Complex(random.normal(2 * k), -random.normal(2 * k + 1));
      const double omega = 2.0 * pi * static_cast<double>(k) / 121.0;
      const Complex derivative = Complex(0.0, omega) * angle * (0.5 * static_cast<double>(fine.size()));
      worst = std::max(worst, std::abs(interpolated[k] - derivative) / std::abs(derivative));
    }
    // sinc^2 is that of continuous time; on the grid it differs by (pi f / 1000 Hz)^2 / 3, at most 3.3e-4 at 10 Hz.
    CHECK(worst < 1.01 * std::pow(pi * rate_hz / 10.0 / 1000.0, 2.0) / 3.0);
  }
}

// Gaussian noise is known by its autocovariance. A trial sees lags up to its own length, and a period T adds what noise
// that never repeats has at T minus the lag.
TEST_CASE("the noise's velocity in a trial is that of noise which never repeats, to half a percent of its variance") {
  // Variance of the velocity, whose density rises as f, between low and high; and of the harmonics that replace it.
  const double low = 1.0 / 121.0, high = 1.0, variance = (high * high - low * low) / 2.0;
  const auto endless = [&](double lag_s) {
    if (lag_s == 0.0) return 1.0;
    const double w = 2.0 * pi * lag_s;
    const auto integral = [&](double f) { return f * std::sin(w * f) / w + std::cos(w * f) / (w * w); };
    return (integral(high) - integral(low)) / variance;
  };
  const auto worst = [&](const Protocol& protocol) {
    const NoiseBand band = noise_band(protocol);
    const double period_s = protocol.noise_period_s();
    double largest = 0.0;
    for (int i = 0; i <= 1210; ++i) {
      double sum = 0.0;
      for (int k = band.first; k <= band.last; ++k) sum += k * std::cos(2.0 * pi * k * (0.1 * i) / period_s);
      largest = std::max(largest, std::abs(sum / (period_s * period_s) / variance - endless(0.1 * i)));
    }
    return largest;
  };
  Protocol protocol;
  CHECK(worst(protocol) < 0.005);
  CHECK(worst(repeating()) > 0.99);
  protocol.noise.vestibular.period_s = 150.0;
  CHECK(worst(protocol) > 0.01);
}

// The period has 1,210,000 samples, and the harmonics fit into transforms of 80 values, 15,125 samples apart.
TEST_CASE("VestibularNoiseMaker: a period with more transforms than the trial has samples") {
  Protocol protocol;
  protocol.noise.vestibular = {.low_hz = 0.0002, .high_hz = 0.003, .period_s = 12'100.0};
  const VestibularNoiseMaker maker(protocol);
  const auto values = static_cast<std::size_t>(protocol.samples()) + 1;
  const Random random(2, streams::vestibular_noise, 4);
  constexpr auto lanes = static_cast<std::size_t>(fft_lanes);
  std::vector<double> rate(values), rates(values * lanes);
  maker.velocity(0.7, random, rate);
  maker.velocity_lanes(std::vector<double>{0.7}, std::vector<Random>{random}, rates);
  double worst = 0.0, scale = 0.0;
  for (std::size_t j = 0; j < values; j += 550) {
    double sum = 0.0;
    for (int k = 3; k <= 36; ++k) {
      const double frequency_hz = k / 12'100.0, turn = 2.0 * pi * frequency_hz * static_cast<double>(j) / 100.0;
      // sqrt(density df), and the factor from angle to velocity.
      const double stddev = 0.7 * 0.2 * rad_per_deg / std::sqrt(k) * rate_per_angle(protocol, frequency_hz);
      const auto normal = [&](int i) { return random.normal(static_cast<std::uint64_t>(i)); };
      sum += stddev * (normal(2 * k + 1) * std::cos(turn) - normal(2 * k) * std::sin(turn));
    }
    worst = std::max({worst, std::abs(sum - rate[j]), std::abs(sum - rates[j * lanes])});
    scale = std::max(scale, std::abs(sum));
  }
  CHECK(scale > 0.0);
  CHECK(worst < 1e-12 * scale);
}

TEST_CASE("VestibularNoiseMaker: Nv scales, and is exactly zero at zero") {
  const VestibularNoiseMaker maker{Protocol{}};
  const Random random(2, streams::vestibular_noise, 4);
  std::vector<double> full(12'101), quarter(12'101), none(12'101, 1.0);
  maker.velocity(1.0, random, full);
  maker.velocity(0.25, random, quarter);
  maker.velocity(0.0, random, none);
  CHECK(std::all_of(none.begin(), none.end(), [](double x) { return x == 0.0; }));
  CHECK(std::equal(full.begin(), full.end(), quarter.begin(), [](double a, double b) { return 0.25 * a == b; }));

  Protocol silent;
  silent.noise.vestibular = {.scale_deg = 0.0, .low_hz = 0.01, .high_hz = 0.0101, .exponent = 1.0};
  VestibularNoiseMaker(silent).velocity(1.0, random, none);
  CHECK(std::all_of(none.begin(), none.end(), [](double x) { return x == 0.0; }));
}

TEST_CASE("VestibularNoiseMaker: trials side by side have the bits that each has alone") {
  constexpr auto lanes = static_cast<std::size_t>(fft_lanes);
  // One transform of all samples (a band too wide to be split), 25 of 484, 44 of 550, and the short protocol's.
  Protocol wide = repeating();
  wide.noise.vestibular.high_hz = 10.0;
  for (const Protocol& protocol : {Protocol{}, repeating(), wide, short_protocol()}) {
    const VestibularNoiseMaker maker(protocol);
    const auto values = static_cast<std::size_t>(protocol.samples()) + 1;
    const std::vector<double> nv{0.2, 0.0, 1.0, 0.5, 0.7};
    std::vector<Random> random;
    for (std::size_t i = 0; i < nv.size(); ++i) random.emplace_back(4, streams::vestibular_noise, i);
    for (const decid::Isa isa : decid::available_isas()) {
      CAPTURE(name(isa));
      std::vector<double> rates(values * lanes, 1.0), alone(values);
      maker.velocity_lanes(nv, random, rates, isa);
      bool equal = true;
      for (std::size_t lane = 0; lane < lanes; ++lane) {
        std::fill(alone.begin(), alone.end(), 0.0);
        if (lane < nv.size()) maker.velocity(nv[lane], random[lane], alone);
        for (std::size_t k = 0; k < values; ++k) equal = equal && rates[k * lanes + lane] == alone[k];
      }
      CHECK(equal);
    }
    std::vector<double> short_of_one(values * lanes - 1);
    CHECK_THROWS_AS(maker.velocity_lanes(nv, random, short_of_one), decid::Error);
  }
}

TEST_CASE("VestibularNoiseMaker: errors") {
  Protocol protocol;
  const VestibularNoiseMaker maker(protocol);
  std::vector<double> wrong(12'100);
  CHECK_THROWS_AS(maker.velocity(1.0, Random(1, streams::vestibular_noise, 0), wrong), decid::Error);
  protocol.noise.vestibular.low_hz = 0.01;
  protocol.noise.vestibular.high_hz = 0.0101;
  CHECK_THROWS_AS(VestibularNoiseMaker{protocol}, decid::Error);
}

TEST_CASE("sensor_noise_level: log-uniform in its range") {
  const SensorNoise noise{.low_deg = 0.001, .high_deg = 0.1};
  constexpr int count = 20'000, cells = 20;
  std::vector<int> histogram(cells);
  bool inside = true;
  for (std::uint64_t item = 0; item < count; ++item) {
    const double level_deg = sensor_noise_level(noise, 3, item) / rad_per_deg;
    const double position = std::log10(level_deg / 0.001) / 2.0;
    inside = inside && position > 0.0 && position < 1.0;
    if (inside) ++histogram[static_cast<std::size_t>(position * cells)];
  }
  CHECK(inside);
  double chi_square = 0.0;
  constexpr double expected = static_cast<double>(count) / cells;
  for (const int n : histogram) chi_square += (n - expected) * (n - expected) / expected;
  CHECK(std::abs(chi_square - (cells - 1)) < 4.0 * std::sqrt(2.0 * (cells - 1)));

  CHECK(sensor_noise_level({.low_deg = 0.0, .high_deg = 0.0}, 3, 1) == 0.0);
  CHECK(sensor_noise_level({.low_deg = 0.02, .high_deg = 0.02}, 3, 1) == 0.02 * rad_per_deg);
}

TEST_CASE("add_sensor_noise: white, of the trial's level") {
  const SensorNoise noise{.low_deg = 0.01, .high_deg = 0.1};
  std::vector<double> sway(200'000, 0.5);
  add_sensor_noise(noise, 3, 17, sway);
  const double level = sensor_noise_level(noise, 3, 17);
  double mean = 0.0, square = 0.0, neighbours = 0.0;
  for (std::size_t k = 0; k < sway.size(); ++k) {
    const double x = (sway[k] - 0.5) / level;
    mean += x / 200'000;
    square += x * x / 200'000;
    if (k > 0) neighbours += x * (sway[k - 1] - 0.5) / level / 200'000;
  }
  const double error = 1.0 / std::sqrt(200'000);
  CHECK(std::abs(mean) < 4.0 * error);
  CHECK(std::abs(square - 1.0) < 4.0 * std::sqrt(2.0) * error);
  CHECK(std::abs(neighbours) < 4.0 * error);

  std::vector<double> other(200'000, 0.5), same(200'000, 0.5), none(10, 0.5);
  add_sensor_noise(noise, 3, 18, other);
  add_sensor_noise(noise, 3, 17, same);
  add_sensor_noise({}, 3, 17, none);
  CHECK(other != sway);
  CHECK(same == sway);
  CHECK(none == std::vector<double>(10, 0.5));
}

TEST_CASE("the velocity's deviation is that of realisations") {
  Protocol protocol = default_protocol();
  for (const double exponent : {1.0, 0.5}) {
    protocol.noise.vestibular.exponent = exponent;
    const VestibularNoiseMaker maker(protocol);
    std::vector<double> rate(static_cast<std::size_t>(protocol.samples()) + 1);
    double squares = 0.0;
    constexpr int realisations = 200;
    for (int i = 0; i < realisations; ++i) {
      maker.velocity(0.5, Random(6, streams::vestibular_noise, static_cast<std::uint64_t>(i)), rate);
      for (const double value : rate) squares += value * value / static_cast<double>(rate.size()) / realisations;
    }
    // Some 120 harmonics a trial, 200 trials: the variance errs by 1 %, its root by half that.
    CHECK(near(0.5 * noise_velocity_stddev(protocol), std::sqrt(squares), 0.02));
  }
  protocol.noise.vestibular.scale_deg = 0.0;
  CHECK(noise_velocity_stddev(protocol) == 0.0);
}
