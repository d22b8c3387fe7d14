// The simulated likelihood: its spectrum, that the truth is likelier than what is not, and trials that fall.
#include "tools/compare/likelihood.hpp"

#include <doctest/doctest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "sim/streams.hpp"
#include "tests/near.hpp"

namespace decid::iterative {
namespace {

sim::Protocol short_sines() {
  sim::Protocol protocol;
  protocol.name = "sines";
  protocol.experiment.stimulus = sim::Sines{{{0.1, 0.5, 0.0}, {0.4, 0.2, 0.0}, {1.1, 0.1, 0.0}}, 10.0, 3, 0.0, 0.0};
  return protocol;
}

std::vector<float> trial(const sim::Simulator& simulator, const sim::Parameters& parameters, std::uint64_t item) {
  std::vector<double> sway(static_cast<std::size_t>(simulator.samples()));
  REQUIRE(simulator.run(parameters, Random(11, sim::streams::vestibular_noise, item), sway).valid);
  return {sway.begin(), sway.end()};
}

}  // namespace

TEST_CASE("fit spectrum: a sine is where it should be, an offset is nowhere") {
  const sim::Protocol protocol = short_sines();
  const TrialSpectrum spectrum(protocol);
  CHECK(spectrum.bins() == 120);  // of 1/30 Hz, up to 4 Hz
  std::vector<double> sway(static_cast<std::size_t>(protocol.samples()));
  for (std::size_t k = 0; k < sway.size(); ++k)
    sway[k] = 5 + 0.01 * std::cos(2 * sim::pi * 1.0 * 0.01 * static_cast<double>(k));
  std::vector<sim::Complex> bins(120);
  spectrum.of(sway, bins);
  // 1 Hz is bin 29 (counted from 0): half the amplitude, times the taper's mean 0.9 (two tenths at a half), times
  // what averaging blocks of 10 samples leaves, sin(0.1 pi) / (10 sin(0.01 pi)).
  const double expected = 0.5 * 0.01 * 0.9 * std::sin(0.1 * sim::pi) / (10 * std::sin(0.01 * sim::pi));
  // Its mirror at -1 Hz and the offset's are 60 and 30 bins away, where the taper's spectrum is 0.
  CHECK(test::near(std::abs(bins[29]), expected, 1e-12));
  // The cosine taper's sidelobes ten bins away are below 1% of the peak.
  for (const std::size_t far : {0u, 10u, 19u, 39u, 60u, 119u}) CHECK(std::abs(bins[far]) < 0.01 * expected);
  const std::vector<int>& bands = spectrum.bands();
  CHECK(bands.front() == 0);
  CHECK(bands.back() == 120);
  for (std::size_t b = 1; b < bands.size(); ++b) CHECK(bands[b] > bands[b - 1]);
  // The noise ends at 1 Hz: the last bin that has it is 29, a band begins after it.
  CHECK(std::ranges::count(bands, 30) == 1);
}

TEST_CASE("likelihood: the cost is its formula's, Student's t about the realisations' mean") {
  const sim::Simulator simulator(short_sines());
  const TrialSpectrum spectrum(simulator.protocol());
  const auto bins = static_cast<std::size_t>(spectrum.bins());
  constexpr std::uint64_t seed = 4, first = 30;
  const sim::Parameters parameters = sim::single_pendulum().parameters.middle();
  std::vector<float> recorded = trial(simulator, parameters, 1);
  const Random sensor(6, sim::streams::sensor_noise, 0);
  for (std::size_t k = 0; k < recorded.size(); ++k)
    recorded[k] += static_cast<float>(0.05 * sim::rad_per_deg * sensor.normal(k));
  std::vector<sim::Complex> y(bins);
  spectrum.of(std::vector<double>(recorded.begin(), recorded.end()), y);

  for (const std::size_t realisations : {2U, 5U}) {
    CAPTURE(realisations);
    const auto count = static_cast<double>(realisations);
    std::vector<std::vector<sim::Complex>> x(realisations, std::vector<sim::Complex>(bins));
    std::vector<double> sway(recorded.size());
    for (std::size_t r = 0; r < realisations; ++r) {
      REQUIRE(simulator.run(parameters, Random(seed, iterative::noise_stream, first + r), sway).valid);
      spectrum.of(sway, x[r]);
    }
    double least = HUGE_VAL, likeliest_deg = 0;
    for (int level = 0; level < 21; ++level) {
      const double noise_deg = 0.0005 * std::pow(2.0, 0.5 * level), noise = noise_deg * sim::rad_per_deg;
      double cost = 0;
      for (std::size_t b = 0; b + 1 < spectrum.bands().size(); ++b) {
        const auto begin = static_cast<std::size_t>(spectrum.bands()[b]),
                   end = static_cast<std::size_t>(spectrum.bands()[b + 1]);
        const auto wide = static_cast<double>(end - begin), freedom = wide * (count - 1);
        std::vector<sim::Complex> mean(bins);
        double residual = 0;
        for (std::size_t k = begin; k < end; ++k) {
          for (std::size_t r = 0; r < realisations; ++r) mean[k] += x[r][k] / count;
          for (std::size_t r = 0; r < realisations; ++r) residual += std::norm(x[r][k] - mean[k]) / (count - 1) / wide;
        }
        const double variance = residual * (1 + 1 / count) + noise * noise / static_cast<double>(simulator.samples());
        for (std::size_t k = begin; k < end; ++k)
          cost += 0.5 *
                  (std::log(variance) + (freedom + 1) * std::log(1 + std::norm(y[k] - mean[k]) / (freedom * variance)));
      }
      if (cost < least) {
        least = cost;
        likeliest_deg = noise_deg;
      }
    }
    const Cost found =
        Likelihood(simulator, recorded).costs(std::vector{parameters}, static_cast<int>(realisations), seed, first)[0];
    CHECK(test::near(found.value, least, 1e-12));
    CHECK(test::near(found.sensor_noise_deg, likeliest_deg, 1e-14));
  }
}

TEST_CASE("likelihood: the truth is likelier than values a quarter of a range away, on any number of threads") {
  const sim::Simulator simulator(short_sines());
  sim::Parameters truth = sim::single_pendulum().parameters.middle();
  truth[sim::Nv] = 0.2;
  const Likelihood likelihood(simulator, trial(simulator, truth, 0));
  std::vector<sim::Parameters> candidates{truth};
  // Only parameters that a trial of 30 s informs.
  for (const std::size_t p : {sim::Kp, sim::Kd, sim::Nv, sim::Delay}) {
    candidates.push_back(truth);
    const sim::ParameterInfo& info = sim::single_pendulum().parameters[p];
    candidates.back()[p] += (p == sim::Nv ? 0.6 : -0.3) * (info.high - info.low);
  }
  const std::vector<Cost> costs = likelihood.costs(candidates, 16, 1, 0);
  for (std::size_t c = 1; c < costs.size(); ++c) {
    CAPTURE(c);
    CHECK(costs[c].value > costs[0].value + 2);
  }
  const int threads = omp_get_max_threads();
  omp_set_num_threads(threads == 1 ? 3 : 1);
  const std::vector<Cost> again = likelihood.costs(candidates, 16, 1, 0);
  const std::vector<Cost> alone = likelihood.costs(std::span(candidates).subspan(2, 1), 16, 1, 0);
  omp_set_num_threads(threads);
  for (std::size_t c = 0; c < costs.size(); ++c) CHECK(costs[c].value == again[c].value);
  CHECK(alone[0].value == costs[2].value);
}

TEST_CASE("likelihood: a fall costs more than any standing trial, an earlier fall more") {
  const sim::Simulator simulator(short_sines());
  const Likelihood likelihood(simulator, trial(simulator, sim::single_pendulum().parameters.middle(), 0));
  sim::Parameters falls = sim::single_pendulum().parameters.middle(), falls_at_once = falls, stands = falls;
  falls[sim::Kp] = falls_at_once[sim::Kp] = 1200;
  falls[sim::Kd] = falls_at_once[sim::Kd] = 130;
  falls[sim::Delay] = 0.20;
  falls_at_once[sim::Delay] = 0.24;
  stands[sim::Delay] = 0.05;
  const std::vector<Cost> costs = likelihood.costs(std::vector{stands, falls, falls_at_once}, 4, 1, 0);
  CHECK(costs[0].sensor_noise_deg > 0);
  CHECK(costs[1].sensor_noise_deg == 0);
  CHECK(std::isfinite(costs[1].value));
  CHECK(costs[0].value < costs[1].value);
  CHECK(costs[1].value < costs[2].value);
}

TEST_CASE("likelihood: invalid requests") {
  const sim::Simulator simulator(short_sines());
  const auto samples = static_cast<std::size_t>(simulator.samples());
  CHECK_THROWS_AS(Likelihood(simulator, std::vector<float>(samples - 1)), Error);
  std::vector<float> broken(samples);
  broken[7] = std::nanf("");
  CHECK_THROWS_AS(Likelihood(simulator, broken), Error);
  const Likelihood likelihood(simulator, std::vector<float>(samples));
  CHECK_THROWS_AS(likelihood.costs(std::vector{sim::single_pendulum().parameters.middle()}, 1, 1, 0), Error);
  sim::Protocol brief;
  brief.experiment.stimulus = sim::Sines{{{0.5, 0.5, 0.0}}, 4.0, 1, 0.0, 0.0};
  CHECK_THROWS_AS(TrialSpectrum{brief}, Error);  // 15 frequencies up to 4 Hz
}

}  // namespace decid::iterative
