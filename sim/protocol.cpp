// Protocols: see protocol.hpp.
#include "sim/protocol.hpp"

#include <variant>

#include "base/error.hpp"
#include "sim/checker.hpp"
#include "sim/noise.hpp"

namespace decid::sim {

namespace {

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
    check.fail("sensor_noise_deg low", "is 0 though high is not",
               "give a value above 0, as the level is drawn from a log-uniform distribution; or 0 for both");
  }
  static_cast<void>(noise_band(protocol));
}

}  // namespace

void Protocol::validate() const {
  experiment.validate(name);
  validate_noise(Checker(name), *this);
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
  experiment.refuse_implausible(name);
}

Sequence& Protocol::sequence() {
  if (Sequence* found = std::get_if<Sequence>(&experiment.stimulus)) return *found;
  throw Error("protocol " + name, "plays another stimulus than a ternary sequence", "use one that plays a sequence");
}

const Sequence& Protocol::sequence() const {
  if (const Sequence* found = std::get_if<Sequence>(&experiment.stimulus)) return *found;
  throw Error("protocol " + name, "plays another stimulus than a ternary sequence", "use one that plays a sequence");
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

}  // namespace decid::sim
