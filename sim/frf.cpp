// Frequency response at the harmonics of a periodic stimulus: see frf.hpp.
#include "sim/frf.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "sim/simulate.hpp"

namespace decid::sim {

namespace {

constexpr double min_amplitude = 3e-3;     // of an excited harmonic, relative to the largest
constexpr double max_amplitude = 1e-6;     // of a line that is not excited
constexpr double highest_frequency = 0.4;  // as a fraction of the sample rate
constexpr int lines_a_side = 3, farthest_line = 8;

/// Returns the 95% quantile of F(2, nu), whose distribution function is 1 - (1 + 2 x / nu)^(-nu / 2).
double quantile_95(double nu) {
  return 0.5 * nu * (decid::exp(-2.0 / nu * decid::log(0.05)) - 1.0);
}

int whole_samples(const Experiment& experiment, int cycles) {
  const double samples = cycles * experiment.cycle_s() * experiment.sample_rate_hz;
  if (cycles < 1) {
    throw Error(Code::setting_out_of_range, "frequency response", "no cycle of the stimulus is left",
                "skip fewer cycles");
  }
  if (std::abs(samples - std::round(samples)) > 1e-6) {
    throw Error(Code::setting_out_of_range, "frequency response",
                "the stimulus' cycles are " + std::to_string(samples) + " samples long",
                "choose a sample rate that makes them whole");
  }
  return static_cast<int>(std::round(samples));
}

}  // namespace

FrequencyResponse::FrequencyResponse(const Experiment& experiment, int skipped_cycles, double bands_per_decade)
    : cycles_(experiment.cycles() - skipped_cycles),
      cycle_s_(experiment.cycle_s()),
      first_(static_cast<std::size_t>(
          std::llround((experiment.lead_in_s() + skipped_cycles * cycle_s_) * experiment.sample_rate_hz))),
      fft_(whole_samples(experiment, cycles_)) {
  const Stimulus stimulus = make_stimulus(experiment);
  const auto step_of = [&](std::size_t k) { return static_cast<int>(k) * experiment.steps_per_sample(); };
  const std::size_t end = first_ + static_cast<std::size_t>(fft_.length());
  std::vector<float> tilt;
  for (std::size_t k = 0; k < end; ++k) tilt.push_back(static_cast<float>(stimulus.tilt_at(step_of(k))));
  const double opened =
      stimulus.tilt_at(std::min(step_of(end), experiment.steps())) - stimulus.tilt_at(step_of(first_));
  if (std::abs(opened) > 0.01 * stimulus.peak_to_peak_rad()) {
    throw Error(Code::setting_out_of_range, "frequency response",
                "the stimulus does not end a cycle where it started it", "use a protocol whose tilt returns");
  }

  const std::vector<Complex> x = transform(tilt);
  const int lines = static_cast<int>(highest_frequency * fft_.length());
  const auto amplitude = [&](int line) { return std::sqrt(std::norm(x[static_cast<std::size_t>(line)])); };
  double largest = 0.0;
  for (int line = 1; line <= lines; ++line) largest = std::max(largest, amplitude(line));
  // Between harmonics, rounding to float leaves the only power.
  const auto is_noise = [&](int line) {
    return line >= 1 && line <= lines && (line % cycles_ != 0 || amplitude(line) <= max_amplitude * largest);
  };
  const double ratio = decid::exp(decid::log(10.0) / bands_per_decade);
  double band_start_hz = 0.0;
  for (int line = cycles_; line <= lines; line += cycles_) {
    if (largest == 0.0 || amplitude(line) < min_amplitude * largest) continue;
    Harmonic harmonic{line, line / (cycles_ * cycle_s_), std::norm(x[static_cast<std::size_t>(line)]), {}};
    std::vector<int> below, above;
    for (int d = 1; d <= farthest_line; ++d) {
      if (below.size() < lines_a_side && is_noise(line - d)) below.push_back(line - d);
      if (above.size() < lines_a_side && is_noise(line + d)) above.push_back(line + d);
    }
    // Takes equal numbers on either side, so that a slope of the noise does not matter.
    const std::size_t sides = std::max<std::size_t>(1, std::min(below.size(), above.size()));
    for (auto* side : {&below, &above}) {
      side->resize(std::min(side->size(), sides));
      harmonic.noise_lines.insert(harmonic.noise_lines.end(), side->begin(), side->end());
    }
    if (bands_.empty() || harmonic.frequency_hz > band_start_hz * ratio) {
      bands_.emplace_back();
      band_start_hz = harmonic.frequency_hz;
    }
    bands_.back().push_back(std::move(harmonic));
  }
}

std::vector<Complex> FrequencyResponse::transform(std::span<const float> signal) const {
  const auto length = static_cast<std::size_t>(fft_.length());
  if (signal.size() < first_ + length) {
    throw Error(Code::size_mismatch, "frequency response",
                "a trial has " + std::to_string(signal.size()) + " samples, and its cycles end at sample " +
                    std::to_string(first_ + length),
                "give whole trials of the protocol");
  }
  const auto part = signal.subspan(first_, length);
  const std::vector<double> values(part.begin(), part.end());
  std::vector<Complex> spectrum(static_cast<std::size_t>(fft_.bins()));
  std::vector<Complex> work(static_cast<std::size_t>(fft_.work_length()));
  fft_.forward(values, spectrum, work);
  return spectrum;
}

std::vector<FrfPoint> FrequencyResponse::measure(std::span<const float> sway_rad,
                                                 std::span<const float> tilt_rad) const {
  const std::vector<Complex> y = transform(sway_rad), x = transform(tilt_rad);
  std::vector<FrfPoint> points;
  for (const Band& band : bands_) {
    Complex cross = 0.0;
    double power = 0.0, weighted_hz = 0.0, noise = 0.0, weighted_noise = 0.0;
    std::set<int> noise_lines;
    bool known = true;
    for (const Harmonic& harmonic : band) {
      const auto line = static_cast<std::size_t>(harmonic.line);
      const double line_power = std::norm(x[line]);
      cross += y[line] * std::conj(x[line]);
      power += line_power;
      weighted_hz += line_power * harmonic.frequency_hz;
      known = known && !harmonic.noise_lines.empty();
      double s2 = 0.0;
      for (const int l : harmonic.noise_lines) {
        s2 += std::norm(y[static_cast<std::size_t>(l)]) / static_cast<double>(harmonic.noise_lines.size());
      }
      noise += s2;
      weighted_noise += s2 * line_power;
      noise_lines.insert(harmonic.noise_lines.begin(), harmonic.noise_lines.end());
    }
    FrfPoint point;
    point.harmonics = static_cast<int>(band.size());
    point.frequency_hz = weighted_hz / power;
    point.response = cross / power;
    point.radius = point.coherence = std::numeric_limits<double>::quiet_NaN();
    if (known) {
      const double variance = weighted_noise / (power * power);
      point.radius = std::sqrt(variance * quantile_95(2.0 * static_cast<double>(noise_lines.size())));
      const double signal = std::max(0.0, (std::norm(point.response) - variance) * power);
      point.coherence = signal > 0.0 ? signal / (signal + cycles_ * noise) : 0.0;
    }
    points.push_back(point);
  }
  return points;
}

std::vector<Complex> FrequencyResponse::linear(const Experiment& experiment, const Parameters& parameters,
                                               double start_s) const {
  std::vector<Complex> responses;
  for (const Band& band : bands_) {
    Complex sum = 0.0;
    double power = 0.0;
    for (const Harmonic& harmonic : band) {
      Complex response = harmonic.power * closed_loop(experiment, parameters, harmonic.frequency_hz);
      if (start_s != 0.0) {
        const auto [sin, cos] = sincos_of_turns(harmonic.frequency_hz * start_s);
        response *= Complex(cos, sin);
      }
      sum += response;
      power += harmonic.power;
    }
    responses.push_back(sum / power);
  }
  return responses;
}

}  // namespace decid::sim
