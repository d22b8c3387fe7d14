// Protocols and their stimulus: see protocol.hpp.
// Sequence: Peterka, J Neurophysiol 88, 2002. Its accumulated sum is the tilt, scaled to the peak-to-peak amplitude.
// All times are counted in whole milliseconds; doubles come in only at the end.
#include "sim/protocol.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>
#include <utility>

#include "base/error.hpp"

namespace decid::sim {
namespace {

constexpr double longest_trial_s = 3600.0;

int milliseconds(double seconds) {
  return static_cast<int>(std::floor(seconds * steps_per_second + 0.5));
}

std::string text(double value) {
  std::ostringstream out;
  out.precision(10);
  out << value;
  return out.str();
}

// Checks the settings of one protocol; every failure names the setting as its file does.
class Checker {
 public:
  explicit Checker(const std::string& protocol) : prefix_("protocol " + protocol + ", ") {}

  [[noreturn]] void fail(const std::string& setting, const std::string& problem, const std::string& remedy) const {
    throw Error(prefix_ + setting, problem, remedy);
  }
  void within(const char* setting, double value, double low, double high) const {
    if (value >= low && value <= high) return;  // false for NaN
    fail(setting, "is " + text(value), "give a value from " + text(low) + " to " + text(high));
  }
  void positive(const char* setting, double value, double high) const {
    if (value > 0.0 && value <= high) return;
    fail(setting, "is " + text(value), "give a value above 0 and at most " + text(high));
  }
  void whole_milliseconds(const char* setting, double seconds) const {
    const double steps = seconds * steps_per_second;
    if (std::abs(steps - std::floor(steps + 0.5)) <= 1e-6) return;
    fail(setting, "is " + text(seconds) + " s", "give a multiple of 0.001 s, the integration step");
  }

 private:
  std::string prefix_;
};

void validate_sequence(const Checker& check, const Sequence& sequence) {
  for (const int coefficient : sequence.feedback) check.within("feedback", coefficient, -2, 2);
  for (const int value : sequence.start) check.within("start", value, 0, 2);
  if (std::ranges::all_of(sequence.start, [](int value) { return value == 0; })) {
    check.fail("start", "is all zero", "set at least one stage to 1 or 2");
  }
  check.positive("state_s", sequence.state_s, longest_trial_s);
  check.within("state_s", sequence.state_s, 1e-3, longest_trial_s);
  check.whole_milliseconds("state_s", sequence.state_s);
  check.positive("amplitude_deg", sequence.amplitude_deg, 45.0);
  check.within("cycles", sequence.cycles, 1, 100'000);
  check.within("lead_in_s", sequence.lead_in_s, 0.0, longest_trial_s);
  check.whole_milliseconds("lead_in_s", sequence.lead_in_s);
  check.within("lead_out_s", sequence.lead_out_s, 0.0, longest_trial_s);
  check.whole_milliseconds("lead_out_s", sequence.lead_out_s);
}

// Highest minus lowest accumulated value of a sequence that sums to zero.
int peak_to_peak(const std::vector<int>& values) {
  int sum = 0, lowest = 0, highest = 0;
  for (const int value : values) {
    sum += value;
    lowest = std::min(lowest, sum);
    highest = std::max(highest, sum);
  }
  return highest - lowest;
}

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
}

}  // namespace

void Protocol::validate() const {
  const Checker check(name);
  validate_sequence(check, sequence);
  check.within("sample_rate_hz", sample_rate_hz, 1.0, steps_per_second);
  if (std::fmod(steps_per_second, sample_rate_hz) != 0.0 || sample_rate_hz != std::floor(sample_rate_hz)) {
    check.fail("sample_rate_hz", "is " + text(sample_rate_hz), "give a whole number that divides 1000");
  }

  const std::vector<int> values = ternary_sequence(sequence);
  int sum = 0;
  for (const int value : values) sum += value;
  if (sum != 0) {
    check.fail("feedback", "makes a sequence that sums to " + std::to_string(sum),
               "use a primitive feedback; the platform would not return at the end of a cycle");
  }
  const double cycle = static_cast<double>(values.size()) * sequence.state_s;
  const double length = sequence.lead_in_s + sequence.cycles * cycle + sequence.lead_out_s;
  if (!(length <= longest_trial_s)) {
    check.fail("the trial", "lasts " + text(length) + " s",
               "shorten it to at most 3600 s: fewer cycles or stages, or shorter states");
  }
  if (!(sequence.offset_s >= 0.0 && sequence.offset_s < cycle)) {
    check.fail("offset_s", "is " + text(sequence.offset_s), "give a value from 0 to below the cycle's " + text(cycle));
  }
  check.whole_milliseconds("offset_s", sequence.offset_s);
  if (steps() % steps_per_sample() != 0) {
    check.fail("the trial", "lasts " + text(length) + " s, not a whole number of samples",
               "change lead_out_s or sample_rate_hz");
  }

  check.positive("body mass_kg", body.mass_kg, 500.0);
  check.positive("body com_height_m", body.com_height_m, 5.0);
  check.positive("body inertia_kgm2", body.inertia_kgm2, 10'000.0);
  validate_noise(check, *this);
}

int Protocol::steps() const {
  const int cycle_ms = static_cast<int>(ternary_sequence(sequence).size()) * milliseconds(sequence.state_s);
  return milliseconds(sequence.lead_in_s) + sequence.cycles * cycle_ms + milliseconds(sequence.lead_out_s);
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

double Protocol::cycle_s() const {
  const int cycle_ms = static_cast<int>(ternary_sequence(sequence).size()) * milliseconds(sequence.state_s);
  return static_cast<double>(cycle_ms) / steps_per_second;
}

bool same_experiment(const Protocol& a, const Protocol& b) {
  return a.sequence == b.sequence && a.sample_rate_hz == b.sample_rate_hz && a.body == b.body;
}

Protocol default_protocol() {
  return {};
}

Protocol short_protocol() {
  Protocol protocol;
  protocol.name = "short";
  protocol.sequence = {.feedback = {0, 0, -1, 1},
                       .start = {0, 0, 0, 1},
                       .state_s = 0.25,
                       .amplitude_deg = 1.0,
                       .offset_s = 0.0,
                       .cycles = 3,
                       .lead_in_s = 1.97,
                       .lead_out_s = 1.73};
  return protocol;
}

std::vector<int> ternary_sequence(const Sequence& sequence) {
  const std::size_t stages = sequence.feedback.size();
  if (stages < 2 || stages > 12 || sequence.start.size() != stages) {
    throw Error("sequence",
                "feedback has " + std::to_string(stages) + " stages, start " + std::to_string(sequence.start.size()),
                "give both the same number of stages, 2 to 12");
  }
  std::size_t longest = 1;  // the number of contents a register can have
  for (std::size_t stage = 0; stage < stages; ++stage) longest *= 3;
  std::vector<int> reg = sequence.start;
  std::vector<int> values;
  do {
    int sum = 0;
    for (std::size_t stage = 0; stage < stages; ++stage) sum += sequence.feedback[stage] * reg[stage];
    const int value = (sum % 3 + 3) % 3;
    std::shift_right(reg.begin(), reg.end(), 1);
    reg.front() = value;
    values.push_back(value == 2 ? -1 : value);
    if (values.size() > longest) {
      throw Error("sequence", "the register never returns to its start",
                  "let the last coefficient of feedback be 1, 2, -1 or -2");
    }
  } while (reg != sequence.start);
  return values;
}

double Stimulus::tilt_at(int step) const {
  const int point = step / interval_steps, beyond = step % interval_steps;
  const auto k = static_cast<std::size_t>(point);
  return beyond == 0 ? tilt_rad[k] : tilt_rad[k] + beyond * (rate_rad_s[k] / steps_per_second);
}

Stimulus make_stimulus(const Protocol& protocol) {
  const Sequence& sequence = protocol.sequence;
  const std::vector<int> values = ternary_sequence(sequence);
  const int state_ms = milliseconds(sequence.state_s);
  const int cycle_ms = static_cast<int>(values.size()) * state_ms;
  const int first_ms = milliseconds(sequence.lead_in_s);
  const int last_ms = first_ms + sequence.cycles * cycle_ms;
  const int offset_ms = milliseconds(sequence.offset_s);
  const double rad_per_count = sequence.amplitude_deg * rad_per_deg / (peak_to_peak(values) * state_ms);

  Stimulus stimulus;
  // The widest grid with a point at every change of the velocity and at every sample.
  stimulus.interval_steps = std::gcd(std::gcd(protocol.steps_per_sample(), state_ms), std::gcd(first_ms, offset_ms));
  const int interval = stimulus.interval_steps;
  const int steps = protocol.steps();
  int count = 0;  // state values, summed over the milliseconds
  for (int k = 0; k < steps; k += interval) {
    const bool moving = k >= first_ms && k < last_ms;
    const int state = (offset_ms + (k - first_ms)) % cycle_ms / state_ms;
    const int value = moving ? values[static_cast<std::size_t>(state)] : 0;
    stimulus.tilt_rad.push_back(count * rad_per_count);
    stimulus.rate_rad_s.push_back(value * (rad_per_count * steps_per_second));
    count += value * interval;
  }
  stimulus.tilt_rad.push_back(count * rad_per_count);
  return stimulus;
}

}  // namespace decid::sim
