// The page of a stimulus: see stimulus_page.hpp. stimulus.js draws it.
#include "tools/report/stimulus_page.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/files/json_object.hpp"
#include "embedded/stimulus_js.hpp"
#include "sim/fft.hpp"
#include "tools/report/json/recording_json.hpp"
#include "tools/report/page.hpp"

namespace decid::tools {
namespace {

constexpr std::size_t max_points = 20'000;

struct Points {
  std::vector<double> x, y;

  Json to_json() const {
    Json json{{"x", Json::array()}, {"y", Json::array()}};
    for (const double value : x) json["x"].push_back(page_number(value));
    for (const double value : y) json["y"].push_back(page_number(value));
    return json;
  }
};

/// The lowest and the highest value of each of max_points / 2 equal spans, in their order.
Points thinned(const Points& all) {
  const std::size_t count = all.x.size(), spans = max_points / 2;
  if (count <= max_points) return all;
  Points kept;
  for (std::size_t span = 0; span < spans; ++span) {
    const auto begin = all.y.begin() + static_cast<std::ptrdiff_t>(count * span / spans);
    const auto end = all.y.begin() + static_cast<std::ptrdiff_t>(count * (span + 1) / spans);
    const auto [low, high] = std::minmax_element(begin, end);
    for (const auto at : {std::min(low, high), std::max(low, high)}) {
      kept.x.push_back(all.x[static_cast<std::size_t>(at - all.y.begin())]);
      kept.y.push_back(*at);
      if (low == high) break;
    }
  }
  return kept;
}

/// At every sample: the tilt, or the velocity from there on.
template <class Value>
Points sampled(const sim::Protocol& protocol, const Value& value) {
  Points points;
  const int samples = protocol.samples(), steps_per_sample = protocol.experiment.steps_per_sample();
  for (int k = 0; k < samples; ++k) {
    points.x.push_back(k / protocol.experiment.sample_rate_hz);
    points.y.push_back(value(k * steps_per_sample) / sim::rad_per_deg);
  }
  return thinned(points);
}

const char* kind_name(const sim::Sequence&) {
  return "ternary sequence";
}
const char* kind_name(const sim::MeasuredTilt&) {
  return "measured tilt";
}
const char* kind_name(const sim::Sines&) {
  return "sines";
}
const char* kind_name(const sim::RaisedCosines&) {
  return "raised cosines";
}

Json spectrum_json(const sim::Protocol& protocol) {
  const AmplitudeSpectrum spectrum = amplitude_spectrum(protocol);
  const double largest = *std::ranges::max_element(spectrum.amplitude_deg);
  Points points;
  for (std::size_t k = 1; k < spectrum.amplitude_deg.size(); ++k) {
    if (!(spectrum.amplitude_deg[k] > 1e-6 * largest)) continue;
    points.x.push_back(static_cast<double>(k) * spectrum.resolution_hz);
    points.y.push_back(spectrum.amplitude_deg[k]);
  }
  return thinned(points).to_json();
}

}  // namespace

AmplitudeSpectrum amplitude_spectrum(const sim::Protocol& protocol) {
  const sim::Stimulus stimulus = sim::make_stimulus(protocol.experiment);
  const int steps_per_sample = protocol.experiment.steps_per_sample();
  const auto first = static_cast<int>(std::lround(protocol.experiment.lead_in_s() * sim::steps_per_second));
  auto samples =
      static_cast<int>(std::lround(protocol.experiment.cycle_s() * sim::steps_per_second)) / steps_per_sample;
  while (sim::max_prime_factor(samples) > 100) --samples;
  std::vector<double> tilt;
  double sum = 0.0;
  for (int k = 0; k < samples; ++k) {
    tilt.push_back(stimulus.tilt_at(first + k * steps_per_sample) / sim::rad_per_deg);
    sum += tilt.back();
  }
  for (double& value : tilt) value -= sum / samples;
  const sim::RealFft fft(samples);
  std::vector<sim::Complex> bins(static_cast<std::size_t>(fft.bins()));
  std::vector<sim::Complex> work(static_cast<std::size_t>(fft.work_length()));
  fft.forward(tilt, bins, work);
  AmplitudeSpectrum spectrum{protocol.experiment.sample_rate_hz / samples, {0.0}};
  for (std::size_t k = 1; k < bins.size(); ++k) {
    const bool alone = 2 * k == static_cast<std::size_t>(samples);  // its mirror image is itself
    spectrum.amplitude_deg.push_back((alone ? 1.0 : 2.0) / samples * std::abs(bins[k]));
  }
  return spectrum;
}

std::string stimulus_html(const sim::Protocol& protocol, const std::string& version, const Call& call) {
  const sim::Stimulus stimulus = sim::make_stimulus(protocol.experiment);
  double fastest = 0.0;
  for (const double rate : stimulus.rate_rad_s) fastest = std::max(fastest, std::abs(rate));
  const Json data{{"version", version},
                  {"call", call_json(call, protocol.name)},
                  {"name", protocol.name},
                  {"kind", std::visit([](const auto& kind) { return kind_name(kind); }, protocol.experiment.stimulus)},
                  {"duration_s", page_number(protocol.duration_s())},
                  {"sample_rate_hz", page_number(protocol.experiment.sample_rate_hz)},
                  {"cycles", protocol.experiment.cycles()},
                  {"cycle_s", page_number(protocol.experiment.cycle_s())},
                  {"lead_in_s", page_number(protocol.experiment.lead_in_s())},
                  {"peak_to_peak_deg", page_number(stimulus.peak_to_peak_rad() / sim::rad_per_deg)},
                  {"fastest_deg_s", page_number(fastest / sim::rad_per_deg)},
                  {"tilt", sampled(protocol, [&](int step) { return stimulus.tilt_at(step); }).to_json()},
                  {"velocity", sampled(protocol, [&](int step) { return stimulus.rate_at(step); }).to_json()},
                  {"spectrum", spectrum_json(protocol)}};
  return page_html({.title = "Stimulus",
                    .lead = "The platform's tilt in space, its velocity, and the frequencies that it contains.",
                    .script = embedded::stimulus_js()},
                   data);
}

}  // namespace decid::tools
