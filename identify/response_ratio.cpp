// Stimulus response ratio of a recording: see response_ratio.hpp.
#include "identify/response_ratio.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/aligned.hpp"

namespace decid {
namespace {

constexpr std::size_t min_trials = 8;
constexpr double highest_hz = 2.5;
/// How many lines on either side the noise's power is averaged over.
constexpr std::size_t smoothing = 4;

/// Measurement noise is estimated between these fractions of the rate: sway has little power there, and resampling does
/// not change it.
constexpr double sensor_from = 0.25, sensor_to = 0.4;

constexpr auto lanes = static_cast<std::size_t>(sim::fft_lanes);
constexpr int groups = ResponseRatio::trials / sim::fft_lanes;
static_assert(groups * sim::fft_lanes == ResponseRatio::trials);

/// Compares each of the trials that stand with the mean of the others. spectra: [line][trial]; response: their mean;
/// weight: one over the noise's power; expected: the response's power by it; of_sensor: the sensor's part of the noise.
ResponseRatio::Spread spread_of(std::span<const sim::Complex> spectra, std::span<const std::size_t> standing,
                                std::span<const sim::Complex> response, std::span<const double> weight, double expected,
                                double of_sensor) {
  const auto count = static_cast<double>(standing.size());
  double sum = 0, squares = 0;
  for (const std::size_t i : standing) {
    double follows = 0;
    for (std::size_t k = 1; k < response.size(); ++k) {
      const sim::Complex own = spectra[k * ResponseRatio::trials + i],
                         others = (response[k] * count - own) * (1 / (count - 1));
      follows += (own * std::conj(others)).real() * weight[k];
    }
    sum += follows / expected;
    squares += follows * follows / (expected * expected);
  }
  // Half of the sensor's power in a line is in phase with the response.
  return {sum / count, std::sqrt(std::max(0.0, squares - sum * sum / count) / (count - 1) +
                                 0.5 * of_sensor / (expected * expected))};
}

}  // namespace

void ResponseRatio::Simulated::put(int trial, std::span<const double> sway_rad) {
  sways_[static_cast<std::size_t>(trial)].assign(sway_rad.begin(), sway_rad.end());
}

ResponseRatio::ResponseRatio(const sim::Protocol& protocol)
    : fft_(protocol.samples()),
      lines_(std::min(
          static_cast<std::size_t>(fft_.bins()),
          1 + static_cast<std::size_t>(highest_hz * protocol.samples() / protocol.experiment.sample_rate_hz))) {}

std::vector<sim::Complex> ResponseRatio::spectra(const Simulated& simulated) const {
  const auto bins = static_cast<std::size_t>(fft_.bins()), samples = static_cast<std::size_t>(fft_.length());
  std::vector<sim::Complex> spectra(static_cast<std::size_t>(trials) * lines_);
  WorkVector<double> in(lanes * samples), out(2 * lanes * bins),
      work(2 * lanes * static_cast<std::size_t>(fft_.work_length()));
  const std::vector<double> silence(samples);
  for (std::size_t g = 0; g < groups; ++g) {
    std::array<const double*, lanes> sways;
    for (std::size_t l = 0; l < lanes; ++l) {
      const std::vector<double>& sway = simulated.sways_[g * lanes + l];
      sways[l] = sway.empty() ? silence.data() : sway.data();
    }
    double* place = in.data();
    for (std::size_t k = 0; k < samples; ++k)
      for (std::size_t l = 0; l < lanes; ++l) *place++ = sways[l][k];
    fft_.forward_lanes(in, out, work);
    for (std::size_t k = 0; k < lines_; ++k)
      for (std::size_t l = 0; l < lanes; ++l)
        spectra[k * trials + g * lanes + l] = {out[2 * k * lanes + l], out[(2 * k + 1) * lanes + l]};
  }
  return spectra;
}

double ResponseRatio::measure(const Simulated& simulated, std::span<const float> sway_rad, Spread* spread) const {
  std::vector<std::size_t> standing;
  for (std::size_t i = 0; i < trials; ++i)
    if (!simulated.sways_[i].empty()) standing.push_back(i);
  if (standing.size() < min_trials) return std::numeric_limits<double>::quiet_NaN();

  const auto bins = static_cast<std::size_t>(fft_.bins());
  std::vector<sim::Complex> recorded(bins), work(static_cast<std::size_t>(fft_.work_length()));
  fft_.forward(std::vector<double>(sway_rad.begin(), sway_rad.end()), recorded, work);
  const std::vector<sim::Complex> spectra = this->spectra(simulated);

  // Mean and variance of each line over the trials that stand.
  const auto count = static_cast<double>(standing.size());
  std::vector<sim::Complex> response(lines_);
  std::vector<double> power(lines_, 0.0);
  for (std::size_t k = 1; k < lines_; ++k) {
    for (const std::size_t i : standing) response[k] += spectra[k * trials + i];
    response[k] = response[k] * (1 / count);
    for (const std::size_t i : standing) power[k] += std::norm(spectra[k * trials + i] - response[k]) / (count - 1);
  }
  const auto from = static_cast<std::size_t>(2 * sensor_from * static_cast<double>(bins)),
             to = static_cast<std::size_t>(2 * sensor_to * static_cast<double>(bins));
  double sensor = 0;
  for (std::size_t k = from; k < to; ++k) sensor += std::norm(recorded[k]) / static_cast<double>(to - from);

  std::vector<double> weight(lines_, 0.0);  // one over the noise's power
  double found = 0, expected = 0, of_sensor = 0;
  for (std::size_t k = 1; k < lines_; ++k) {
    const std::size_t first = k > smoothing ? k - smoothing : 1, last = std::min(k + smoothing, lines_ - 1);
    double noise = 0;
    for (std::size_t j = first; j <= last; ++j) noise += power[j] / static_cast<double>(last - first + 1);
    noise += sensor;
    if (noise <= 0) continue;
    weight[k] = 1 / noise;
    found += (recorded[k] * std::conj(response[k])).real() / noise;
    expected += std::norm(response[k]) / noise;
    of_sensor += std::norm(response[k]) * sensor / (noise * noise);
  }
  if (spread != nullptr) *spread = spread_of(spectra, standing, response, weight, expected, of_sensor);
  return found / expected;
}

double ood_score(double distance, double usual, double response_ratio) {
  constexpr double max = 1.0;
  const double missing = std::isnan(response_ratio) ? max : std::clamp(1 - response_ratio, 0.0, max);
  return (distance / usual + ood_missing_weight * missing) / ood_border;
}

}  // namespace decid
