// Protocols: see protocol.hpp. Their stimulus is sim/stimulus.cpp's part.
#include "sim/protocol.hpp"

#include <charconv>
#include <cmath>
#include <sstream>
#include <variant>

#include "base/error.hpp"
#include "sim/checker.hpp"
#include "sim/noise.hpp"

namespace decid::sim {

int milliseconds(double seconds) {
  return static_cast<int>(std::floor(seconds * steps_per_second + 0.5));
}

std::string setting_text(double value) {
  std::ostringstream out;
  out.precision(10);
  out << value;
  return out.str();
}

std::string given_text(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

void Checker::fail(const std::string& setting, const std::string& problem, const std::string& remedy) const {
  throw Error(prefix_ + setting, problem, remedy);
}

void Checker::within(const std::string& setting, double value, double low, double high) const {
  if (value >= low && value <= high) return;
  fail(setting, "is " + given_text(value), "give a value from " + setting_text(low) + " to " + setting_text(high));
}

void Checker::positive(const std::string& setting, double value, double high) const {
  if (value > 0.0 && value <= high) return;
  fail(setting, "is " + given_text(value), "give a value above 0 and at most " + setting_text(high));
}

void Checker::whole_milliseconds(const std::string& setting, double seconds) const {
  const double steps = seconds * steps_per_second;
  if (std::abs(steps - std::floor(steps + 0.5)) <= 1e-6) return;
  fail(setting, "is " + given_text(seconds) + " s", "give a multiple of 0.001 s, the integration step");
}

namespace {

void validate_noise(const Checker& check, const Protocol& protocol) {
  const VestibularNoise& noise = protocol.vestibular_noise;
  check.within("vestibular_noise scale_deg", noise.scale_deg, 0.0, 100.0);
  // Above a tenth of the sample rate, interpolation between samples would add noise outside the band.
  check.positive("vestibular_noise high_hz", noise.high_hz, protocol.sample_rate_hz / 10.0);
  check.positive("vestibular_noise low_hz", noise.low_hz, noise.high_hz);
  check.within("vestibular_noise exponent", noise.exponent, 0.0, 4.0);
  check.within("sensor_noise_deg high", protocol.sensor_noise.high_deg, 0.0, 90.0);
  check.within("sensor_noise_deg low", protocol.sensor_noise.low_deg, 0.0, protocol.sensor_noise.high_deg);
  if (protocol.sensor_noise.high_deg > 0.0 && protocol.sensor_noise.low_deg == 0.0) {
    check.fail("sensor_noise_deg low", "is 0 though high is not",
               "give a value above 0, as the level is drawn from a log-uniform distribution; or 0 for both");
  }
  static_cast<void>(noise_band(protocol));
}

/// Noise and spectra are made by transforms of the trial's length.
void validate_length(const Checker& check, const Protocol& protocol) {
  const int samples = protocol.samples(), largest = largest_prime_factor(samples);
  if (largest <= largest_fft_prime) return;
  int more = 1;
  while (largest_prime_factor(samples + more) > largest_fft_prime) ++more;
  check.fail("the trial",
             "has " + std::to_string(samples) + " samples, a multiple of the prime " + std::to_string(largest) +
                 "; primes up to " + std::to_string(largest_fft_prime) + " can be transformed",
             "lengthen lead_out_s by " + setting_text(more / protocol.sample_rate_hz) + " s");
}

}  // namespace

void Protocol::validate() const {
  const Checker check(name);
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
  validate_noise(check, *this);
}

void Protocol::refuse_implausible() const {
  // Those of ASCII, and those of Unicode from U+0080 to U+009F, which terminals obey too.
  for (std::size_t i = 0; i < name.size(); ++i) {
    const auto byte = static_cast<unsigned char>(name[i]);
    const bool second = i + 1 < name.size() && byte == 0xC2 && static_cast<unsigned char>(name[i + 1]) < 0xA0;
    if (byte >= 0x20 && byte != 0x7F && !second) continue;
    throw Error("protocol name", "has a control character at byte " + std::to_string(i + 1),
                "give a name of plain text, on one line");
  }
  const Checker check(name);
  const double least = body.mass_kg * body.com_height_m * body.com_height_m;
  if (!(body.inertia_kgm2 >= least * (1.0 - 1e-6))) {
    check.fail("body inertia_kgm2",
               "is " + given_text(body.inertia_kgm2) + ", below mass_kg * com_height_m^2 = " + setting_text(least) +
                   ", the least that a body can have about the ankles",
               "give the inertia about the ankles: that about the centre of mass plus mass_kg * com_height_m^2; or a "
               "subject");
  }
  const MeasuredTilt* measured = std::get_if<MeasuredTilt>(&stimulus);
  if (measured == nullptr || measured->cycles == 1) return;
  const std::string problem = broken_joint(measured->tilt_deg);
  if (!problem.empty()) check.fail("measured tilt_deg", problem, "give cycles 1, or a recording of whole cycles");
}

Sequence& Protocol::sequence() {
  if (Sequence* found = std::get_if<Sequence>(&stimulus)) return *found;
  throw Error("protocol " + name, "plays another stimulus than a ternary sequence", "use one that plays a sequence");
}

const Sequence& Protocol::sequence() const {
  if (const Sequence* found = std::get_if<Sequence>(&stimulus)) return *found;
  throw Error("protocol " + name, "plays another stimulus than a ternary sequence", "use one that plays a sequence");
}

int Protocol::cycles() const {
  return std::visit([](const auto& kind) { return kind.cycles; }, stimulus);
}

double Protocol::lead_in_s() const {
  return std::visit([](const auto& kind) { return kind.lead_in_s; }, stimulus);
}

double Protocol::cycle_s() const {
  return static_cast<double>(cycle_steps(stimulus, steps_per_sample())) / steps_per_second;
}

int Protocol::steps() const {
  const auto cycle = static_cast<int>(cycle_steps(stimulus, steps_per_sample()));
  return std::visit(
      [cycle](const auto& kind) {
        return milliseconds(kind.lead_in_s) + kind.cycles * cycle + milliseconds(kind.lead_out_s);
      },
      stimulus);
}

int Protocol::steps_per_sample() const {
  return steps_per_second / static_cast<int>(sample_rate_hz);
}

int Protocol::samples() const {
  return steps() / steps_per_sample();
}

double Protocol::duration_s() const {
  return static_cast<double>(steps()) / steps_per_second;
}

bool same_experiment(const Protocol& a, const Protocol& b) {
  return a.stimulus == b.stimulus && a.sample_rate_hz == b.sample_rate_hz && a.body == b.body;
}

Protocol default_protocol() {
  return {};
}

Protocol short_protocol() {
  Protocol protocol;
  protocol.name = "short";
  protocol.stimulus = Sequence{.feedback = {0, 0, -1, 1},
                               .start = {0, 0, 0, 1},
                               .state_s = 0.25,
                               .amplitude_deg = 1.0,
                               .offset_s = 0.0,
                               .cycles = 3,
                               .lead_in_s = 1.97,
                               .lead_out_s = 1.73};
  return protocol;
}

}  // namespace decid::sim
