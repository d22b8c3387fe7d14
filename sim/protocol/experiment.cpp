// Experiments: see experiment.hpp. sim/protocol/stimulus.cpp checks the stimulus.
#include "sim/protocol/experiment.hpp"

#include <cmath>
#include <variant>

#include "sim/fft.hpp"
#include "sim/protocol/detail/checker.hpp"

namespace decid::sim {
namespace {

constexpr int min_samples = 4;  // which a recording that begins late is interpolated from

/// Transforms of the trial's length make noise and spectra.
void validate_length(const Checker& check, const Experiment& experiment) {
  const int samples = experiment.samples(), largest = max_prime_factor(samples);
  if (samples < min_samples)
    check.fail("the trial", "has " + std::to_string(samples) + " samples",
               "give a longer cycle or a higher sample_rate_hz, for at least " + std::to_string(min_samples));
  if (largest <= max_fft_prime) return;
  int more = 1;
  while (max_prime_factor(samples + more) > max_fft_prime) ++more;
  check.fail("the trial",
             "has " + std::to_string(samples) + " samples, a multiple of the prime " + std::to_string(largest) +
                 "; transforms allow primes up to " + std::to_string(max_fft_prime),
             "lengthen lead_out_s by " + setting_text(more / experiment.sample_rate_hz) + " s");
}

}  // namespace

void Experiment::validate(const std::string& protocol) const {
  const Checker check(protocol);
  check.within("sample_rate_hz", sample_rate_hz, 1.0, steps_per_second);
  if (std::fmod(steps_per_second, sample_rate_hz) != 0.0 || sample_rate_hz != std::floor(sample_rate_hz)) {
    check.fail("sample_rate_hz", "is " + given_text(sample_rate_hz), "give a whole number that divides 1000");
  }
  check_stimulus(check, *this);
  if (steps() % steps_per_sample() != 0) {
    check.fail("the trial", "lasts " + setting_text(duration_s()) + " s, not a whole number of samples",
               "change lead_out_s or sample_rate_hz");
  }
  validate_length(check, *this);
  check.positive("body mass_kg", body.mass_kg, 500.0);
  check.positive("body com_height_m", body.com_height_m, 5.0);
  check.positive("body inertia_kgm2", body.inertia_kgm2, 10'000.0);
}

void Experiment::refuse_implausible(const std::string& protocol) const {
  const Checker check(protocol);
  const double min_inertia = body.mass_kg * body.com_height_m * body.com_height_m;
  if (!(body.inertia_kgm2 >= min_inertia * (1.0 - 1e-6))) {
    check.fail("body inertia_kgm2",
               "is " + given_text(body.inertia_kgm2) + ", below mass_kg * com_height_m^2 = " +
                   setting_text(min_inertia) + ", the minimum for a body about the ankles",
               "give the inertia about the ankles: that about the centre of mass plus mass_kg * com_height_m^2; or "
               "give body.participant");
  }
  const MeasuredTilt* measured = std::get_if<MeasuredTilt>(&stimulus);
  if (measured == nullptr || measured->cycles == 1) return;
  const std::string problem = broken_joint(measured->tilt_deg);
  if (!problem.empty()) check.fail("measured tilt_deg", problem, "give cycles 1, or a recording of whole cycles");
}

int Experiment::cycles() const {
  return std::visit([](const auto& kind) { return kind.cycles; }, stimulus);
}

double Experiment::lead_in_s() const {
  return std::visit([](const auto& kind) { return kind.lead_in_s; }, stimulus);
}

double Experiment::cycle_s() const {
  return static_cast<double>(cycle_steps(stimulus, steps_per_sample())) / steps_per_second;
}

int Experiment::steps() const {
  const auto cycle = static_cast<int>(cycle_steps(stimulus, steps_per_sample()));
  return std::visit(
      [cycle](const auto& kind) {
        return milliseconds(kind.lead_in_s) + kind.cycles * cycle + milliseconds(kind.lead_out_s);
      },
      stimulus);
}

int Experiment::steps_per_sample() const {
  return steps_per_second / static_cast<int>(sample_rate_hz);
}

int Experiment::samples() const {
  return steps() / steps_per_sample();
}

double Experiment::duration_s() const {
  return static_cast<double>(steps()) / steps_per_second;
}

std::vector<double> tilt_at_samples(const Experiment& experiment, const Stimulus& stimulus) {
  const int samples = experiment.samples(), steps_per_sample = experiment.steps_per_sample();
  std::vector<double> tilt_rad;
  tilt_rad.reserve(static_cast<std::size_t>(samples));
  for (int k = 0; k < samples; ++k) tilt_rad.push_back(stimulus.tilt_at(k * steps_per_sample));
  return tilt_rad;
}

}  // namespace decid::sim
