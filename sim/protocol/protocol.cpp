// Protocols: see protocol.hpp.
#include "sim/protocol/protocol.hpp"

#include <cmath>
#include <string>
#include <utility>
#include <variant>

#include "base/error.hpp"
#include "sim/noise.hpp"
#include "sim/protocol/detail/checker.hpp"

namespace decid::sim {

namespace {

constexpr int default_period_trials = 2;
constexpr double longest_period_trials = 100.0;
constexpr double longest_standing_s = 60.0;

void validate_noise(const Checker& check, const Protocol& protocol) {
  const VestibularNoise& vestibular = protocol.noise.vestibular;
  check.within("vestibular_noise scale_deg", vestibular.scale_deg, 0.0, 100.0);
  // Above a tenth of the sample rate, interpolation between samples would add noise outside the band.
  check.positive("vestibular_noise high_hz", vestibular.high_hz, protocol.experiment.sample_rate_hz / 10.0);
  check.positive("vestibular_noise low_hz", vestibular.low_hz, vestibular.high_hz);
  check.within("vestibular_noise exponent", vestibular.exponent, 0.0, 4.0);
  const SensorNoise& sensor = protocol.noise.sensor;
  check.within("sensor_noise_deg high", sensor.high_deg, 0.0, 90.0);
  check.within("sensor_noise_deg low", sensor.low_deg, 0.0, sensor.high_deg);
  if (sensor.high_deg > 0.0 && sensor.low_deg == 0.0) {
    check.fail("sensor_noise_deg low", "is 0, and high is not",
               "give a value above 0, because the level is log-uniform; or give 0 for both");
  }
  const double period_s = vestibular.period_s, rate_hz = protocol.experiment.sample_rate_hz;
  if (period_s != 0.0) {
    const double duration_s = protocol.duration_s();
    if (!(period_s >= duration_s * (1.0 - 1e-9) && period_s <= longest_period_trials * duration_s)) {
      check.fail("vestibular_noise period_s", "is " + given_text(period_s),
                 "give the trial's " + setting_text(duration_s) + " s or more, up to " +
                     setting_text(longest_period_trials * duration_s) + " s; or leave it out");
    }
    check.whole_samples("vestibular_noise period_s", period_s, rate_hz);
    const int largest = max_prime_factor(protocol.noise_period_samples());
    if (largest > max_fft_prime) {
      check.fail("vestibular_noise period_s", "has a multiple of the prime " + std::to_string(largest) + " of samples",
                 "give another period; transforms allow primes up to " + std::to_string(max_fft_prime));
    }
  }
  static_cast<void>(noise_band(protocol));
}

/// A cycle before the trial must fit its first sample and end as it begins.
void validate_cycle_before(const Checker& check, const Protocol& protocol) {
  if (protocol.experiment.lead_in_s() != 0.0)
    check.fail("moved_before", "is true, and lead_in_s is " + setting_text(protocol.experiment.lead_in_s()),
               "give a lead_in_s of 0: the platform rests during it");
  check.whole_samples("moved_before: the cycle", protocol.experiment.cycle_s(), protocol.experiment.sample_rate_hz);
  const Experiment whole = protocol.with_time_before().experiment;
  whole.validate(protocol.name + ", moved_before");
  whole.refuse_implausible(protocol.name + ", moved_before");
}

/// Standing and an earlier cycle need noise too.
void validate_standing(const Checker& check, const Protocol& protocol) {
  check.within("standing_s", protocol.standing_s, 0.0, longest_standing_s);
  check.whole_samples("standing_s", protocol.standing_s, protocol.experiment.sample_rate_hz);
  if (protocol.moved_before) validate_cycle_before(check, protocol);
  const Protocol whole = protocol.with_time_before();
  if (whole.samples() == protocol.samples()) return;
  static_cast<void>(noise_band(whole));
  const int largest = max_prime_factor(whole.noise_period_samples());
  if (largest > max_fft_prime) {
    check.fail(protocol.moved_before ? "moved_before" : "standing_s",
               "makes the vestibular noise's period a multiple of the prime " + std::to_string(largest) + " of samples",
               "give another standing_s; transforms allow primes up to " + std::to_string(max_fft_prime));
  }
}

void validate_conditions(const Checker& check, const Conditions& conditions) {
  for (std::size_t c = 0; c < condition_count; ++c) {
    const ConditionInfo& about = info(static_cast<Condition>(c));
    const Severity& severity = conditions.severity[c];
    const std::string key = std::string("recording ") + about.key;
    check.within(key + " share", severity.fraction, 0.0, 1.0);
    check.within(key + " high", severity.high, 0.0, about.max);
    check.within(key + " low", severity.low, 0.0, severity.high);
  }
  const Severity& low_pass = conditions[Condition::low_pass];
  if (low_pass.fraction > 0.0 && low_pass.low == 0.0)
    check.fail("recording low_pass_hz low", "is 0", "give a frequency above 0");
}

}  // namespace

void Protocol::validate() const {
  experiment.validate(name);
  validate_noise(Checker(name), *this);
  validate_conditions(Checker(name), conditions);
  Checker(name).within("body_heights low", heights.low, 0.5, 1.0);
  Checker(name).within("body_heights high", heights.high, 1.0, 2.0);
  validate_standing(Checker(name), *this);
  Checker(name).within("gravity_dead_band_deg", gravity_dead_band_deg, 0.0, 5.0);
}

Protocol Protocol::ideal() const {
  Protocol same = *this;
  same.noise.sensor = {};
  same.conditions = {};
  same.heights = {};
  return same;
}

Protocol Protocol::from_rest() const {
  Protocol same = *this;
  same.standing_s = 0.0;
  same.moved_before = false;
  return same;
}

Protocol Protocol::with_time_before() const {
  Protocol whole = from_rest();
  if (standing_s == 0.0 && !moved_before) return whole;
  std::visit(
      [this](auto& kind) {
        kind.lead_in_s += standing_s;
        kind.cycles += moved_before ? 1 : 0;
      },
      whole.experiment.stimulus);
  const bool lasts = noise_period_samples() >= whole.samples();
  whole.noise.vestibular.period_s = lasts ? noise_period_s() : 0.0;
  return whole;
}

void Protocol::refuse_implausible() const {
  // Control characters of ASCII, and Unicode's from U+0080 to U+009F, which terminals obey too.
  for (std::size_t i = 0; i < name.size(); ++i) {
    const auto byte = static_cast<unsigned char>(name[i]);
    const bool second = i + 1 < name.size() && byte == 0xC2 && static_cast<unsigned char>(name[i + 1]) < 0xA0;
    if (byte >= 0x20 && byte != 0x7F && !second) continue;
    throw Error(Code::setting_malformed, "protocol name", "has a control character at byte " + std::to_string(i + 1),
                "give a name of plain text, on one line");
  }
  experiment.refuse_implausible(name);
}

int Protocol::noise_period_samples() const {
  const double period_s = noise.vestibular.period_s;
  return period_s == 0.0 ? default_period_trials * samples()
                         : static_cast<int>(std::floor(period_s * experiment.sample_rate_hz + 0.5));
}

double Protocol::noise_period_s() const {
  const double period_s = noise.vestibular.period_s;
  return period_s == 0.0 ? noise_period_samples() / experiment.sample_rate_hz : period_s;
}

Sequence& Protocol::sequence() {
  return const_cast<Sequence&>(std::as_const(*this).sequence());
}

const Sequence& Protocol::sequence() const {
  if (const Sequence* found = std::get_if<Sequence>(&experiment.stimulus)) return *found;
  throw Error(Code::setting_conflict, "protocol " + name, "does not play a ternary sequence",
              "use a protocol that plays a sequence");
}

Protocol default_protocol() {
  return {};
}

Protocol short_protocol() {
  Protocol protocol;
  protocol.name = "short";
  protocol.experiment.stimulus = Sequence{.feedback = {0, 0, -1, 1},
                                          .start = {0, 0, 0, 1},
                                          .state_s = 0.25,
                                          .amplitude_deg = 1.0,
                                          .offset_s = 0.0,
                                          .cycles = 3,
                                          .lead_in_s = 1.97,
                                          .lead_out_s = 1.73};
  return protocol;
}

ParameterTable Protocol::ranges() const {
  const double ratio = experiment.body.mgh() / Body{}.mgh();
  std::vector<ParameterInfo> scaled(parameters().begin(), parameters().end());
  for (ParameterInfo& info : scaled) {
    if (!info.scales_with_mgh) continue;
    info.low *= ratio;
    info.high *= ratio;
    if (info.convention) *info.convention *= ratio;
  }
  return ParameterTable(std::move(scaled));
}

}  // namespace decid::sim
