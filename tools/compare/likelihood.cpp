// The simulated likelihood: see likelihood.hpp.
#include "tools/compare/likelihood.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "base/per_thread.hpp"

namespace decid::iterative {
namespace {

constexpr double block_rate_hz = 10.0;
constexpr int min_bins = 20;
constexpr int min_bins_in_band = 4;
constexpr double tapered = 0.1;     // part of the trial at each end
constexpr double band_width = 0.2;  // of its frequency
constexpr double temperature = 2.0;
constexpr double fallen_cost = 1e9;     // beyond any trial that stands, which costs some thousand
constexpr double fallen_earlier = 1e6;  // for a trial's length

/// Levels of measurement noise: each sqrt(2) times the level before.
constexpr int noise_levels = 21;
constexpr double lowest_noise_deg = 0.0005;

double sensor_noise_deg(int level) {
  return lowest_noise_deg * exp(0.34657359027997264 * level);  // log(2) / 2
}

int block_samples(const sim::Protocol& protocol) {
  return std::max(1, static_cast<int>(std::lround(protocol.experiment.sample_rate_hz / block_rate_hz)));
}

}  // namespace

TrialSpectrum::TrialSpectrum(const sim::Protocol& protocol)
    : samples_(protocol.samples()),
      block_(block_samples(protocol)),
      length_(std::max(1, samples_ / block_)),
      bin_hz_(protocol.experiment.sample_rate_hz / (static_cast<double>(block_) * length_)),
      fft_(length_) {
  bins_ = std::min(fft_.bins() - 1, static_cast<int>(highest_hz / bin_hz_));
  if (bins_ < min_bins)
    throw Error(Code::setting_out_of_range, "fit",
                "trials of " + std::to_string(protocol.duration_s()) + " s have " + std::to_string(bins_) +
                    " frequencies up to 4 Hz",
                "give a protocol that lasts longer than 5 s and is sampled at 10 Hz or more");
  const int ends = static_cast<int>(tapered * length_);
  taper_.assign(static_cast<std::size_t>(length_), 1.0);
  for (int j = 0; j < ends; ++j) {
    const double rise = 0.5 - 0.5 * sincos_of_turn(2 * j + 1, 4LL * ends).cos;
    taper_[static_cast<std::size_t>(j)] = taper_[static_cast<std::size_t>(length_ - 1 - j)] = rise;
  }
  // Where the noise's band begins and ends the residual's power jumps: no band across.
  const auto edge = [&](double hz) { return static_cast<int>(std::min(hz / bin_hz_ + 1e-6, 1e9)); };
  const int noise_begins = edge(protocol.noise.vestibular.low_hz) - 1,
            noise_ends = edge(protocol.noise.vestibular.high_hz);
  bands_.push_back(0);
  while (bands_.back() < bins_) {
    const int first = bands_.back();
    int next = first + std::max(min_bins_in_band, static_cast<int>(band_width * (first + 1)));
    for (const int jump : {noise_begins, noise_ends})
      if (first < jump && jump < next) next = jump;
    bands_.push_back(std::min(next, bins_));
  }
}

void TrialSpectrum::of(std::span<const double> sway_rad, std::span<sim::Complex> out) const {
  struct Scratch {
    std::vector<double> means;
    std::vector<sim::Complex> spectrum, work;
  };
  auto& [means, spectrum, work] = per_thread<Scratch>();
  means.resize(static_cast<std::size_t>(length_));
  spectrum.resize(static_cast<std::size_t>(fft_.bins()));
  work.resize(static_cast<std::size_t>(fft_.work_length()));
  const double* sample = sway_rad.data();
  const double scale = 1.0 / (static_cast<double>(block_) * length_);
  for (double& mean : means) {
    double sum = 0;
    for (int j = 0; j < block_; ++j) sum += *sample++;
    mean = sum * scale;
  }
  double level = 0, weight = 0;
  for (std::size_t j = 0; j < means.size(); ++j) {
    level += means[j] * taper_[j];
    weight += taper_[j];
  }
  level /= weight;
  for (std::size_t j = 0; j < means.size(); ++j) means[j] = (means[j] - level) * taper_[j];
  fft_.forward(means, spectrum, work);
  std::copy_n(spectrum.begin() + 1, bins_, out.begin());
}

Likelihood::Likelihood(const sim::Simulator& simulator, std::span<const float> sway_rad)
    : simulator_(simulator), spectrum_(simulator.protocol()) {
  if (sway_rad.size() != static_cast<std::size_t>(simulator.samples()))
    throw Error(Code::size_mismatch, "fit",
                "the recording has " + std::to_string(sway_rad.size()) + " samples, the protocol " +
                    std::to_string(simulator.samples()),
                "give one for each sample of the protocol");
  const std::vector<double> sway(sway_rad.begin(), sway_rad.end());
  for (const double value : sway)
    if (!std::isfinite(value))
      throw Error(Code::value_invalid, "fit", "the recording has a value that is not finite", "repair it");
  recorded_.resize(static_cast<std::size_t>(spectrum_.bins()));
  spectrum_.of(sway, recorded_);
}

std::vector<Cost> Likelihood::costs(std::span<const sim::Parameters> candidates, int realisations, std::uint64_t seed,
                                    std::uint64_t first) const {
  if (realisations < 2)
    throw Error(Code::setting_out_of_range, "fit", "fewer than 2 realisations of the noise", "ask for at least 2");
  const auto bins = static_cast<std::size_t>(spectrum_.bins());
  const auto each = static_cast<std::size_t>(realisations);
  std::vector<sim::Complex> spectra(candidates.size() * each * bins);
  std::vector<double> stood_s(candidates.size() * each);
  simulator_.run_all(
      static_cast<int>(stood_s.size()),
      [&](int i) {
        const auto index = static_cast<std::size_t>(i);
        return sim::TrialInput{candidates[index / each], Random(seed, noise_stream, first + index % each)};
      },
      [&](int i, const sim::Outcome& outcome, std::span<double> sway) {
        const auto index = static_cast<std::size_t>(i);
        stood_s[index] = outcome.valid ? outcome.end_s : -outcome.end_s;  // negative: fell
        if (outcome.valid) spectrum_.of(sway, std::span(spectra).subspan(index * bins, bins));
      });
  std::vector<Cost> costs(candidates.size());
  for (std::size_t c = 0; c < costs.size(); ++c)
    costs[c] =
        cost(std::span(spectra).subspan(c * each * bins, each * bins), std::span(stood_s).subspan(c * each, each));
  return costs;
}

Cost Likelihood::cost(std::span<const sim::Complex> simulated, std::span<const double> stood_s) const {
  const auto bins = static_cast<std::size_t>(spectrum_.bins());
  const auto standing = static_cast<std::size_t>(std::ranges::count_if(stood_s, [](double s) { return s > 0; }));
  if (standing < 2 || 2 * standing < stood_s.size()) {
    double stood = 0;
    for (const double s : stood_s) stood += std::abs(s);
    const double part = stood / (static_cast<double>(stood_s.size()) * simulator_.protocol().duration_s());
    return {fallen_cost + fallen_earlier * (1 - part), 0};
  }
  const double count = static_cast<double>(standing);
  // Distance from the mean and residual power, bin by bin.
  struct Scratch {
    std::vector<double> distance2, power;
  };
  auto& [distance2, power] = per_thread<Scratch>();
  distance2.assign(bins, 0);
  power.assign(bins, 0);
  for (std::size_t k = 0; k < bins; ++k) {
    sim::Complex mean = 0;
    for (std::size_t r = 0; r < stood_s.size(); ++r)
      if (stood_s[r] > 0) mean += simulated[r * bins + k];
    mean /= count;
    for (std::size_t r = 0; r < stood_s.size(); ++r)
      if (stood_s[r] > 0) power[k] += std::norm(simulated[r * bins + k] - mean);
    distance2[k] = std::norm(recorded_[k] - mean);
  }
  double least[noise_levels] = {};
  const std::vector<int>& bands = spectrum_.bands();
  for (std::size_t b = 0; b + 1 < bands.size(); ++b) {
    const auto begin = static_cast<std::size_t>(bands[b]), end = static_cast<std::size_t>(bands[b + 1]);
    const double freedom = static_cast<double>(end - begin) * (count - 1);
    double residual = 0;
    for (std::size_t k = begin; k < end; ++k) residual += power[k];
    residual *= (1 + 1 / count) / freedom;
    for (int level = 0; level < noise_levels; ++level) {
      const double noise = sensor_noise_deg(level) * sim::rad_per_deg;
      const double variance = residual + noise * noise / static_cast<double>(simulator_.samples());
      // The logarithm of a product: one logarithm a band. A factor is at most (1 + 1e20), a band has some ten.
      double sum = 0, product = 1;
      for (std::size_t k = begin; k < end; ++k) {
        product *= 1 + std::min(distance2[k] / (freedom * variance), 1e20);
        if (product > 1e200) {
          sum += log(product);
          product = 1;
        }
      }
      least[level] += static_cast<double>(end - begin) * log(variance) + (freedom + 1) * (sum + log(product));
    }
  }
  const auto* likeliest = std::ranges::min_element(least);
  return {*likeliest / temperature - log(count / static_cast<double>(stood_s.size())),
          sensor_noise_deg(static_cast<int>(likeliest - least))};
}

}  // namespace decid::iterative
