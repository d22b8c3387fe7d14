// Whether a recording follows the tilt: see following.hpp.
#include "identify/following.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace decid {
namespace {

constexpr int trials = 32, fewest_trials = 8;
constexpr double highest_hz = 2.5;
/// Lines on either side over which the noise's power is averaged.
constexpr std::size_t smoothing = 4;

/// The sensor's noise is what a recording has between these parts of its rate: sway has little there, and resampling
/// leaves it alone.
constexpr double sensor_from = 0.25, sensor_to = 0.4;

}  // namespace

sim::Parameters simulable(sim::Parameters parameters) {
  for (double& p : parameters) p = std::max(p, 0.0);
  parameters[sim::Delay] = std::min(parameters[sim::Delay], sim::longest_delay_s);
  return parameters;
}

Following::Following(const sim::Simulator& simulator)
    : simulator_(simulator),
      fft_(simulator.samples()),
      lines_(std::min(
          static_cast<std::size_t>(fft_.bins()),
          1 + static_cast<std::size_t>(highest_hz * simulator.samples() / simulator.protocol().sample_rate_hz))) {}

std::vector<sim::Complex> Following::spectrum(std::span<const double> sway_rad) const {
  std::vector<sim::Complex> lines(static_cast<std::size_t>(fft_.bins()));
  std::vector<sim::Complex> work(static_cast<std::size_t>(fft_.work_length()));
  fft_.forward(sway_rad, lines, work);
  return lines;
}

double Following::measure(const sim::Parameters& parameters, std::span<const float> sway_rad) const {
  const std::vector<sim::Complex> recorded = spectrum(std::vector<double>(sway_rad.begin(), sway_rad.end()));

  const sim::Parameters simulated = simulable(parameters);
  std::vector<std::vector<sim::Complex>> spectra(trials);
  simulator_.run_all(
      trials,
      [&](int i) {
        return sim::Trial{simulated, Random(0, Stream::vestibular_noise, static_cast<std::uint64_t>(i))};
      },
      [&](int i, const sim::Outcome& outcome, std::span<double> sway) {
        if (outcome.valid) spectra[static_cast<std::size_t>(i)] = spectrum(sway);
      });
  std::erase_if(spectra, [](const auto& s) { return s.empty(); });
  if (spectra.size() < fewest_trials) return std::numeric_limits<double>::quiet_NaN();

  // Mean and variance of each line over the trials.
  const auto count = static_cast<double>(spectra.size());
  std::vector<sim::Complex> response(lines_);
  std::vector<double> power(lines_, 0.0);
  for (std::size_t k = 1; k < lines_; ++k) {
    for (const auto& s : spectra) response[k] += s[k];
    response[k] = response[k] * (1 / count);
    for (const auto& s : spectra) power[k] += std::norm(s[k] - response[k]) / (count - 1);
  }
  const auto bins = static_cast<double>(recorded.size());
  const auto from = static_cast<std::size_t>(2 * sensor_from * bins),
             to = static_cast<std::size_t>(2 * sensor_to * bins);
  double sensor = 0;
  for (std::size_t k = from; k < to; ++k) sensor += std::norm(recorded[k]) / static_cast<double>(to - from);

  double found = 0, expected = 0;
  for (std::size_t k = 1; k < lines_; ++k) {
    const std::size_t first = k > smoothing ? k - smoothing : 1, last = std::min(k + smoothing, lines_ - 1);
    double noise = 0;
    for (std::size_t j = first; j <= last; ++j) noise += power[j] / static_cast<double>(last - first + 1);
    noise += sensor;
    if (noise <= 0) continue;
    found += (recorded[k] * std::conj(response[k])).real() / noise;
    expected += std::norm(response[k]) / noise;
  }
  return found / expected;
}

double unfamiliarity(double distance, double usual, double following) {
  constexpr double weight = 0.4, most = 1.0, border = 1.17;
  const double missing = std::isnan(following) ? most : std::clamp(1 - following, 0.0, most);
  return (distance / usual + weight * missing) / border;
}

}  // namespace decid
