// Protocols as JSON: round trips to the bit, defaults, and every way to get it wrong.
#include "sim/protocol/protocol_json.hpp"

#include <cmath>

#include "base/files/json_object.hpp"
#include "tests/helpers.hpp"
#include "tests/sim/tiny_protocol.hpp"

using namespace decid;
using namespace decid::test;

namespace {

void check_round_trip(const sim::Protocol& a) {
  const std::string text = to_json(a);
  const sim::Protocol b = sim::protocol_from_json(text, "round trip");
  CHECK(b.name == a.name);
  CHECK(b.experiment == a.experiment);  // every number exactly
  CHECK(b.noise.vestibular.scale_deg == a.noise.vestibular.scale_deg);
  CHECK(b.noise.vestibular.low_hz == a.noise.vestibular.low_hz);
  CHECK(b.noise.vestibular.high_hz == a.noise.vestibular.high_hz);
  CHECK(b.noise.vestibular.exponent == a.noise.vestibular.exponent);
  CHECK(b.noise.vestibular.period_s == a.noise_period_s());
  CHECK(b.noise.sensor.low_deg == a.noise.sensor.low_deg);
  CHECK(b.noise.sensor.high_deg == a.noise.sensor.high_deg);
  CHECK(to_json(b) == text);
}

auto parsing(const std::string& text) {
  return [text] { sim::protocol_from_json(text, "my.json"); };
}

// Reads JSON as a user's file, without measured tilts.
sim::Protocol from_people(const std::string& text) {
  const sim::ReadTilt none = [](const sim::TiltFileReference&, double) { return std::vector<double>(); };
  return sim::protocol_from_text(text, {.where = "mine.json", .read_tilt = none});
}

}  // namespace

TEST_CASE("protocols come back to the bit") {
  check_round_trip(sim::default_protocol());
  check_round_trip(sim::short_protocol());
  check_round_trip(tiny_protocol());
  sim::Protocol odd = sim::default_protocol();
  odd.name = "a \"quoted\" n\xC3\xA4me\n";  // nobody may write that any more, but files may hold it
  odd.sequence().amplitude_deg = std::nextafter(1.0, 2.0);
  odd.experiment.body.mass_kg = 1.0 / 3.0 + 70.0;
  odd.experiment.body.inertia_kgm2 = 100.0 * 1.1;
  odd.noise.vestibular.scale_deg = 0.1 + 0.2;
  odd.noise.vestibular.low_hz = std::nextafter(1.0 / 121.0, 0.0);
  odd.noise.vestibular.period_s = 200.03;
  odd.noise.vestibular.exponent = std::nextafter(1.0, 0.0);
  odd.noise.sensor = {0.001, 0.1};
  check_round_trip(odd);
  odd.noise.sensor = {0.02, 0.02};
  check_round_trip(odd);
}

TEST_CASE("every kind of stimulus comes back to the bit") {
  const auto check = [](sim::StimulusKind kind) {
    sim::Protocol protocol = sim::default_protocol();
    protocol.experiment.stimulus = std::move(kind);
    check_round_trip(protocol);
  };
  sim::MeasuredTilt measured{.tilt_deg = {}, .cycles = 2, .lead_in_s = 1.5, .lead_out_s = 2.5};
  for (int k = 0; k < 1000; ++k) measured.tilt_deg.push_back(std::nextafter(k / 97.0, 3.0) - 5.0);
  check(measured);
  sim::Sines sines{.components = {}, .cycle_s = 20.0, .cycles = 3, .lead_in_s = 0.5, .lead_out_s = 0.25};
  for (int k = 1; k <= 100; ++k)
    sines.components.push_back(
        {.frequency_hz = k * 0.05, .amplitude_deg = 0.1 / (3.0 + k), .phase_deg = 1000.0 / (3.0 + k)});
  check(sines);
  using sim::Move;
  check(sim::RaisedCosines{
      .moves = {{.shape = Move::Shape::pulse, .start_s = 0.3, .duration_s = 0.7, .amplitude_deg = 1.0 / 3.0},
                {.shape = Move::Shape::step, .start_s = 1.1, .duration_s = 0.7, .amplitude_deg = -2.0 / 3.0}},
      .cycle_s = 7.7,
      .cycles = 1,
      .lead_in_s = 0.1,
      .lead_out_s = 0.2});
}

TEST_CASE("a protocol's missing keys have the default's values") {
  const sim::Protocol base = sim::default_protocol();
  const sim::Protocol empty = from_people("{}");
  CHECK(to_json(empty) == to_json(base));
  const sim::Protocol some =
      sim::protocol_from_json(R"({"name": "mine", "sequence": {"amplitude_deg": 2}, "sensor_noise_deg": 0.5})", "some");
  CHECK(empty.name == "default");
  CHECK(some.name == "mine");
  CHECK(some.sequence().amplitude_deg == 2.0);
  CHECK(some.sequence().feedback == base.sequence().feedback);
  CHECK(some.noise.sensor.low_deg == 0.5);
  CHECK(some.noise.sensor.high_deg == 0.5);
  const sim::Protocol range = sim::protocol_from_json(R"({"sensor_noise_deg": [0.001, 1e-1]})", "range");
  CHECK(range.noise.sensor.low_deg == 0.001);
  CHECK(range.noise.sensor.high_deg == 0.1);
}

TEST_CASE(
    "the noise's period: twice the trial's length in protocol files, the trial's length in older data sets and "
    "models") {
  const auto check = [](const std::string& text, double written_s, double carried_s) {
    CAPTURE(text);
    CHECK(from_people(text).noise_period_s() == written_s);
    CHECK(sim::protocol_from_json(text, "a model").noise_period_s() == carried_s);
  };
  check("{}", 242.0, 121.0);
  check(R"({"sequence": {"cycles": 3}})", 363.0, 181.5);
  check(R"({"vestibular_noise": {"scale_deg": 0.1}})", 242.0, 121.0);
  check(to_json(sim::short_protocol()), 127.4, 127.4);
  for (const char* number : {"121", "150", "242", "1000"}) {
    const double period_s = std::stod(number);
    check(std::string(R"({"vestibular_noise": {"period_s": )") + number + "}}", period_s, period_s);
  }
  check(R"({"vestibular_noise": {"period_s": "trial"}})", 121.0, 121.0);
  check(R"({"sequence": {"cycles": 3}, "vestibular_noise": {"period_s": "trial"}})", 181.5, 181.5);
  check(R"({"vestibular_noise": {"period_s": 0}})", 242.0, 242.0);
  for (const char* wrong : {"\"trials\"", "null", "[121]"}) {
    check_error(parsing(std::string(R"({"vestibular_noise": {"period_s": )") + wrong + "}}"), Code::setting_malformed,
                "'vestibular_noise.period_s'");
  }
  check_error(parsing(R"({"vestibular_noise": {"period_s": 120}})"), Code::setting_out_of_range, "period_s");
  // A defect of the experiment comes before a period that it decides.
  check_error(parsing(R"({"sample_rate_hz": 0})"), Code::setting_out_of_range, "sample_rate_hz");
}

TEST_CASE("bodies of other heights") {
  const sim::Protocol protocol = sim::protocol_from_json(R"({"body_heights": [0.8, 1.1]})", "my.json");
  CHECK(protocol.heights.low == 0.8);
  CHECK(protocol.heights.high == 1.1);
  CHECK(sim::protocol_from_json(to_json(protocol), "again").heights.high == 1.1);
  CHECK_FALSE(contains(to_json(sim::Protocol{}), "body_heights"));
  check_error(parsing(R"({"body_heights": [1.1, 0.8]})"), Code::setting_out_of_range, "body_heights");
  check_error(parsing(R"({"body_heights": [0.1, 0.8]})"), Code::setting_out_of_range, "body_heights");
  check_error(parsing(R"({"body_heights": [1, 3]})"), Code::setting_out_of_range, "body_heights");
  check_error(parsing(R"({"body_heights": 1.2})"), Code::setting_out_of_range, "body_heights");
  check_error(parsing(R"({"body_heights": [0.8, 0.9]})"), Code::setting_out_of_range, "body_heights");
  const sim::Protocol ideal =
      sim::protocol_from_json(
          R"({"name": "a", "body_heights": [0.8, 1.1], "sensor_noise_deg": 0.1, "recording": {"gain": {"size": 0.1}}})",
          "my.json")
          .ideal();
  CHECK(to_json(ideal) == to_json(sim::protocol_from_json(R"({"name": "a"})", "my.json")));
  check_error(parsing(R"({"body_heights": "tall"})"), Code::setting_malformed, "'body_heights'");
}

TEST_CASE("standing") {
  sim::Protocol protocol = sim::protocol_from_json(R"({"standing_s": 12.5})", "my.json");
  CHECK(protocol.standing_s == 12.5);
  const std::string text = to_json(protocol);
  CHECK(sim::protocol_from_json(text, "again").standing_s == 12.5);
  CHECK(to_json(sim::protocol_from_json(text, "again")) == text);
  CHECK_FALSE(contains(to_json(sim::Protocol{}), "standing_s"));
  check_error(parsing(R"({"standing_s": 0.005})"), Code::setting_out_of_range, "standing_s");
  check_error(parsing(R"({"standing_s": "long"})"), Code::setting_malformed, "'standing_s'");
}

TEST_CASE("keys stand in the documented order") {
  const std::string text = to_json(sim::default_protocol());
  std::size_t last = 0;
  for (const char* key : {"\"name\"",      "\"sequence\"",        "\"feedback\"",       "\"start\"",
                          "\"state_s\"",   "\"amplitude_deg\"",   "\"offset_s\"",       "\"cycles\"",
                          "\"lead_in_s\"", "\"lead_out_s\"",      "\"sample_rate_hz\"", "\"body\"",
                          "\"mass_kg\"",   "\"com_height_m\"",    "\"inertia_kgm2\"",   "\"vestibular_noise\"",
                          "\"scale_deg\"", "\"low_hz\"",          "\"high_hz\"",        "\"exponent\"",
                          "\"period_s\"",  "\"sensor_noise_deg\""}) {
    const std::size_t found = text.find(key);
    INFO(key);
    REQUIRE(found != std::string::npos);
    CHECK(found >= last);
    last = found;
  }
}

TEST_CASE("a body may be given by a mass and a height") {
  const sim::Protocol protocol =
      sim::protocol_from_json(R"({"body": {"participant": {"mass_kg": 88.86, "height_m": 1.80}}})", "my.json");
  // Half a unit of what the default is printed with.
  CHECK(std::abs(protocol.experiment.body.mass_kg - 86.283) <= 0.0005);
  CHECK(std::abs(protocol.experiment.body.com_height_m - 0.99119) <= 0.000005);
  CHECK(std::abs(protocol.experiment.body.inertia_kgm2 - 101.895) <= 0.0005);
  CHECK_FALSE(protocol.experiment == sim::default_protocol().experiment);
  const sim::Protocol again = sim::protocol_from_json(to_json(protocol), "again");
  CHECK(again.experiment.body == protocol.experiment.body);
  const sim::Protocol old =
      sim::protocol_from_json(R"({"body": {"subject": {"mass_kg": 88.86, "height_m": 1.80}}})", "old");
  CHECK(old.experiment == protocol.experiment);  // the key of decid 0.1
  check_error(parsing(R"({"body": {"participant": {"mass_kg": 80}}})"), Code::setting_missing,
              "'body.participant.height_m'");
  check_error(parsing(R"({"body": {"participant": {"height_m": 1.8}}})"), Code::setting_missing,
              "'body.participant.mass_kg'");
  check_error(parsing(R"({"body": {"participant": {"mass_kg": 80, "height_m": 18}}})"), Code::setting_out_of_range,
              "body.participant");
  check_error(parsing(R"({"body": {"participant": {"mass_kg": -1, "height_m": 1.8}}})"), Code::setting_out_of_range,
              "body.participant");
  check_error(parsing(R"({"body": {"participant": {"mass_kg": 80, "height_m": 1.8, "age": 30}}})"),
              Code::setting_unknown, "'body.participant.age'");
  check_error(parsing(R"({"body": {"mass_kg": 80, "participant": {"mass_kg": 80, "height_m": 1.8}}})"),
              Code::setting_conflict, "'body.mass_kg'");
}

TEST_CASE("an incomplete body is refused, and the missing keys are named") {
  const std::pair<const char*, const char*> incomplete[]{
      {R"("mass_kg": 12)", "'body.com_height_m', 'body.inertia_kgm2'"},
      {R"("com_height_m": 0.4)", "'body.mass_kg', 'body.inertia_kgm2'"},
      {R"("inertia_kgm2": 103)", "'body.mass_kg', 'body.com_height_m'"},
      {R"("mass_kg": 12, "com_height_m": 0.4)", "'body.inertia_kgm2'"},
      {R"("mass_kg": 12, "inertia_kgm2": 2)", "'body.com_height_m'"},
      {R"("com_height_m": 0.4, "inertia_kgm2": 2)", "'body.mass_kg'"}};
  for (const auto& [keys, missing] : incomplete)
    check_error(parsing(R"({"body": {)" + std::string(keys) + "}}"), Code::setting_missing, missing);
  const sim::Body robot =
      sim::protocol_from_json(R"({"body": {"mass_kg": 12, "com_height_m": 0.4, "inertia_kgm2": 2}})", "my.json")
          .experiment.body;
  CHECK(robot == sim::Body{.mass_kg = 12.0, .com_height_m = 0.4, .inertia_kgm2 = 2.0});
  CHECK(sim::protocol_from_json(R"({"body": {}})", "my.json").experiment.body == sim::Body{});
}

TEST_CASE("what is wrong is refused with its place or key") {
  struct Row {
    const char* text;
    Code code;
    const char* fact;
  };
  const Row rows[]{
      {"{\n  \"name\": oops\n}", Code::setting_malformed, "line 2, column 11"},
      {"", Code::setting_malformed, "line 1"},
      {"{\"name\": \"\xFF\"}", Code::setting_malformed, "UTF-8"},
      {"{\"sample_rate_hz\": 1e999}", Code::setting_malformed, "1e999"},
      {"[1, 2]", Code::setting_malformed, "my.json"},
      {R"({"nam": "x"})", Code::setting_unknown, "'nam'"},
      {R"({"cycles": 3})", Code::setting_unknown, "'sequence'"},
      {R"({"cycles": 3, "sines": {"components": [{"frequency_hz": 0.2, "amplitude_deg": 1}], "cycle_s": 20}})",
       Code::setting_unknown, "'sines'"},
      {R"({"amplitude_deg": 3})", Code::setting_unknown, "'sequence'"},
      {R"({"mass_kg": 80, "height_m": 1.8})", Code::setting_unknown, "'body.participant'"},
      {R"({"low_hz": 1})", Code::setting_unknown, "'vestibular_noise'"},
      {R"({"drift_deg": {"size": 1}})", Code::setting_unknown, "'recording'"},
      {R"({"sequence": {"cycle": 2}})", Code::setting_unknown, "'sequence.cycle'"},
      {R"({"body": {"mass": 80}})", Code::setting_unknown, "'body.mass'"},
      {R"({"vestibular_noise": {"low": 1}})", Code::setting_unknown, "'vestibular_noise.low'"},
      {R"({"sequence": {"cycles": 1, "cycles": 2}})", Code::setting_conflict, "'cycles'"},
      {R"({"name": 3})", Code::setting_malformed, "'name'"},
      {R"({"sequence": 3})", Code::setting_malformed, "my.json"},
      {R"({"sequence": {"cycles": 2.5}})", Code::setting_malformed, "'sequence.cycles'"},
      {R"({"sequence": {"cycles": 4294967297}})", Code::setting_malformed, "'sequence.cycles'"},
      {R"({"sequence": {"cycles": -4294967297}})", Code::setting_malformed, "'sequence.cycles'"},
      {R"({"sequence": {"feedback": [0, "1"]}})", Code::setting_malformed, "'sequence.feedback'"},
      {R"({"sequence": {"start": 1}})", Code::setting_malformed, "'sequence.start'"},
      {R"({"sample_rate_hz": "100"})", Code::setting_malformed, "'sample_rate_hz'"},
      {R"({"sample_rate_hz": null})", Code::setting_malformed, "'sample_rate_hz'"},
      {R"({"body": {"mass_kg": true, "com_height_m": 1, "inertia_kgm2": 101}})", Code::setting_malformed,
       "'body.mass_kg'"},
      {R"({"sensor_noise_deg": "low"})", Code::setting_malformed, "'sensor_noise_deg'"},
      {R"({"sensor_noise_deg": [0.1]})", Code::setting_malformed, "'sensor_noise_deg'"},
      {R"({"sensor_noise_deg": [0.1, 0.2, 0.3]})", Code::setting_malformed, "'sensor_noise_deg'"},
      {R"({"sensor_noise_deg": [0.1, "x"]})", Code::setting_malformed, "'sensor_noise_deg'"},
      {R"({"sensor_noise_deg": [0.1, 0.01]})", Code::setting_out_of_range, "sensor_noise"},
      // A trial that cannot have its noise.
      {R"({"vestibular_noise": {"low_hz": 0.501, "high_hz": 0.502}})", Code::setting_out_of_range, "vestibular_noise"},
      {R"({"sines": {"components": [{"frequency_hz": 1, "amplitude_deg": 1}], "cycle_s": 200.11}})",
       Code::setting_out_of_range, "lead_out_s"},
      {R"({"sequence": {"lead_out_s": 79.11}})", Code::setting_out_of_range, "lead_out_s"},
      // Stimuli.
      {R"({"sines": {"components": [{"frequency_hz": 1, "amplitude_deg": 1}], "cycle_s": 10}, "sequence": {}})",
       Code::setting_conflict, "'sequence' and 'sines'"},
      {R"({"sines": {}})", Code::setting_missing, "'sines.components'"},
      {R"({"sines": {"components": 3, "cycle_s": 10}})", Code::setting_malformed, "'sines.components'"},
      {R"({"sines": {"components": [3], "cycle_s": 10}})", Code::setting_malformed, "sines.components[0]"},
      {R"({"sines": {"components": [{"frequency_hz": 1, "amplitude_deg": 1}]}})", Code::setting_missing,
       "'sines.cycle_s'"},
      {R"({"sines": {"components": [{"frequency_hz": 1}], "cycle_s": 10}})", Code::setting_missing,
       "'sines.components[0].amplitude_deg'"},
      {R"({"sines": {"components": [{"frequency_hz": "1", "amplitude_deg": 1}], "cycle_s": 10}})",
       Code::setting_malformed, "'sines.components[0].frequency_hz'"},
      {R"({"sines": {"components": [{"frequency_hz": 1, "amplitude_deg": 1, "phase": 1}], "cycle_s": 10}})",
       Code::setting_unknown, "'sines.components[0].phase'"},
      {R"({"sines": {"components": [], "cycle_s": 10}})", Code::setting_out_of_range, "0 entries"},
      {R"({"sines": {"components": [{"frequency_hz": 20, "amplitude_deg": 1}], "cycle_s": 10}})",
       Code::setting_out_of_range, "frequency_hz"},
      {R"({"raised_cosines": {"moves": [], "cycle_s": 10, "period": 1}})", Code::setting_unknown,
       "'raised_cosines.period'"},
      {R"({"raised_cosines": {"moves": [{"start_s": 0, "duration_s": 1, "amplitude_deg": 1, "shape": "ramp"}]}})",
       Code::setting_malformed, "'raised_cosines.moves[0].shape'"},
      {R"({"raised_cosines": {"moves": [{"start_s": 0, "amplitude_deg": 1}], "cycle_s": 10}})", Code::setting_missing,
       "'raised_cosines.moves[0].duration_s'"},
      {R"({"recording": {"lost_s": 5}})", Code::setting_malformed, R"({"size": 5})"},
      {R"({"recording": {"lost_s": [1, 5]}})", Code::setting_malformed, "'recording.lost_s'"},
      {R"({"measured": {}})", Code::setting_missing, "'file'"},
      {R"({"measured": 1})", Code::setting_malformed, "my.json"},
      {R"({"measured": {"tilt_deg": [0, "1"]}})", Code::setting_malformed, "'measured.tilt_deg'"},
      {R"({"measured": {"tilt_deg": [0, 1], "unit": "deg"}})", Code::setting_conflict, "'measured.unit'"},
      {R"({"measured": {"tilt_deg": [0]}})", Code::setting_out_of_range, "tilt_deg"},
      // A protocol in a data set or a model needs no other file.
      {R"({"measured": {"file": "tilt.csv"}})", Code::not_supported, "'measured.file'"}};
  for (const Row& row : rows) {
    CAPTURE(row.text);
    check_error(parsing(row.text), row.code, row.fact);
  }
}

TEST_CASE("another sequence starts at its start, unless its offset is given") {
  const auto sequence = [](const std::string& keys) {
    return sim::protocol_from_json("{\"sequence\": {" + keys + "}}", "p.json").sequence();
  };
  const std::string other = R"("feedback": [0, 0, -1, 1], "start": [0, 0, 0, 1])";
  CHECK(sequence(other).offset_s == 0.0);
  CHECK(sequence(other + R"(, "offset_s": 3.5)").offset_s == 3.5);
  CHECK(sequence(R"("start": [0, 0, 0, 0, 1])").offset_s == 0.0);
  CHECK(sequence(R"("amplitude_deg": 2)").offset_s == 25.63);
  // Its keys carry their object's name in errors.
  check_error(parsing(R"({"sequence": {"state_s": 0}})"), Code::setting_out_of_range, "my.json");
  check_error(parsing(R"({"sequence": {"feedback": [0, 1]}})"), Code::setting_out_of_range, "2 stages");
}

TEST_CASE("a key of an inner object that lies outside is named with its object") {
  const Json protocol = parse_json(to_json(sim::default_protocol()), "protocol");
  int moved_keys = 0;
  for (const auto& [outer, object] : protocol.items()) {
    if (!object.is_object()) continue;
    for (const auto& [key, value] : object.items()) {
      if (outer == "body" && key == "mass_kg") continue;  // also a participant's
      Json moved = protocol;
      moved[key] = value;
      check_error(parsing(moved.dump()), Code::setting_unknown, "move it into '" + outer + "'");
      ++moved_keys;
    }
  }
  CHECK(moved_keys > 10);
}
