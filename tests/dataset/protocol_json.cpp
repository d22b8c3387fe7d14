// Protocols as JSON: round trips to the bit, defaults, and every way to get it wrong.
#include "dataset/protocol_json.hpp"

#include <bit>
#include <cmath>
#include <cstdint>

#include "helpers.hpp"

using namespace decid;
using namespace decid::dataset;
using namespace decid::test;

namespace {

void check_same_bits(double a, double b) {
  CHECK(std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b));
}

void check_round_trip(const sim::Protocol& a) {
  const std::string text = to_json(a);
  const sim::Protocol b = protocol_from_json(text, "round trip");
  CHECK(b.name == a.name);
  CHECK(b.sequence().feedback == a.sequence().feedback);
  CHECK(b.sequence().start == a.sequence().start);
  check_same_bits(b.sequence().state_s, a.sequence().state_s);
  check_same_bits(b.sequence().amplitude_deg, a.sequence().amplitude_deg);
  check_same_bits(b.sequence().offset_s, a.sequence().offset_s);
  CHECK(b.sequence().cycles == a.sequence().cycles);
  check_same_bits(b.sequence().lead_in_s, a.sequence().lead_in_s);
  check_same_bits(b.sequence().lead_out_s, a.sequence().lead_out_s);
  check_same_bits(b.sample_rate_hz, a.sample_rate_hz);
  check_same_bits(b.body.mass_kg, a.body.mass_kg);
  check_same_bits(b.body.com_height_m, a.body.com_height_m);
  check_same_bits(b.body.inertia_kgm2, a.body.inertia_kgm2);
  check_same_bits(b.vestibular_noise.scale_deg, a.vestibular_noise.scale_deg);
  check_same_bits(b.vestibular_noise.low_hz, a.vestibular_noise.low_hz);
  check_same_bits(b.vestibular_noise.high_hz, a.vestibular_noise.high_hz);
  check_same_bits(b.vestibular_noise.exponent, a.vestibular_noise.exponent);
  check_same_bits(b.sensor_noise.low_deg, a.sensor_noise.low_deg);
  check_same_bits(b.sensor_noise.high_deg, a.sensor_noise.high_deg);
  CHECK(to_json(b) == text);
}

auto parsing(const std::string& text) {
  return [text] { protocol_from_json(text, "my.json"); };
}

}  // namespace

TEST_CASE("protocols come back to the bit") {
  check_round_trip(sim::default_protocol());
  check_round_trip(sim::short_protocol());
  check_round_trip(tiny_protocol());
  sim::Protocol odd = sim::default_protocol();
  odd.name = "a \"quoted\" n\xC3\xA4me\n";
  odd.sequence().amplitude_deg = std::nextafter(1.0, 2.0);
  odd.body.mass_kg = 1.0 / 3.0 + 70.0;
  odd.body.inertia_kgm2 = 100.0 * 1.1;
  odd.vestibular_noise.scale_deg = 0.1 + 0.2;
  odd.vestibular_noise.low_hz = std::nextafter(1.0 / 121.0, 0.0);
  odd.vestibular_noise.exponent = std::nextafter(1.0, 0.0);
  odd.sensor_noise = {0.001, 0.1};
  check_round_trip(odd);
  odd.sensor_noise = {0.02, 0.02};
  check_round_trip(odd);
}

TEST_CASE("what a protocol leaves out is the default's") {
  const sim::Protocol base = sim::default_protocol();
  const sim::Protocol empty = protocol_from_json("{}", "empty");
  CHECK(to_json(empty) == to_json(base));
  const sim::Protocol some =
      protocol_from_json(R"({"name": "mine", "sequence": {"amplitude_deg": 2}, "sensor_noise_deg": 0.5})", "some");
  CHECK(some.name == "mine");
  CHECK(some.sequence().amplitude_deg == 2.0);
  CHECK(some.sequence().feedback == base.sequence().feedback);
  CHECK(some.sensor_noise.low_deg == 0.5);
  CHECK(some.sensor_noise.high_deg == 0.5);
  const sim::Protocol range = protocol_from_json(R"({"sensor_noise_deg": [0.001, 1e-1]})", "range");
  CHECK(range.sensor_noise.low_deg == 0.001);
  CHECK(range.sensor_noise.high_deg == 0.1);
}

TEST_CASE("keys stand in the documented order") {
  const std::string text = to_json(sim::default_protocol());
  std::size_t last = 0;
  for (const char* key : {"\"name\"",
                          "\"sequence\"",
                          "\"feedback\"",
                          "\"start\"",
                          "\"state_s\"",
                          "\"amplitude_deg\"",
                          "\"offset_s\"",
                          "\"cycles\"",
                          "\"lead_in_s\"",
                          "\"lead_out_s\"",
                          "\"sample_rate_hz\"",
                          "\"body\"",
                          "\"mass_kg\"",
                          "\"com_height_m\"",
                          "\"inertia_kgm2\"",
                          "\"vestibular_noise\"",
                          "\"scale_deg\"",
                          "\"low_hz\"",
                          "\"high_hz\"",
                          "\"exponent\"",
                          "\"sensor_noise_deg\""}) {
    const std::size_t found = text.find(key);
    INFO(key);
    REQUIRE(found != std::string::npos);
    CHECK(found >= last);
    last = found;
  }
}

TEST_CASE("bad JSON is refused with line and column") {
  check_error(parsing("{\n  \"name\": oops\n}"), {"my.json", "line 2, column 11", "correct the file"});
  check_error(parsing(""), {"my.json", "not valid JSON", "line 1"});
  check_error(parsing("{\"name\": \"\xFF\"}"), {"my.json", "not valid JSON", "UTF-8"});
  check_error(parsing("{\"sample_rate_hz\": 1e999}"), {"my.json", "not valid JSON", "1e999"});
  check_error(parsing("[1, 2]"), {"my.json", "the text is not a JSON object"});
}

TEST_CASE("unknown keys are refused by name, with those that exist") {
  check_error(parsing(R"({"nam": "x"})"), {"my.json", "unknown key 'nam'", "sample_rate_hz"});
  check_error(parsing(R"({"sequence": {"cycle": 2}})"), {"my.json", "unknown key 'sequence.cycle'", "cycles"});
  check_error(parsing(R"({"body": {"mass": 80}})"), {"my.json", "unknown key 'body.mass'", "mass_kg"});
  check_error(parsing(R"({"vestibular_noise": {"low": 1}})"), {"unknown key 'vestibular_noise.low'", "low_hz"});
}

TEST_CASE("wrong types are refused by key") {
  check_error(parsing(R"({"name": 3})"), {"my.json", "'name' is 3", "a text"});
  check_error(parsing(R"({"sequence": 3})"), {"my.json", "sequence is not a JSON object"});
  check_error(parsing(R"({"sequence": {"cycles": 2.5}})"), {"'sequence.cycles' is 2.5", "a whole number"});
  check_error(parsing(R"({"sequence": {"cycles": 4294967297}})"), {"'sequence.cycles' is 4294967297"});
  check_error(parsing(R"({"sequence": {"cycles": -4294967297}})"), {"'sequence.cycles' is -4294967297"});
  check_error(parsing(R"({"sequence": {"feedback": [0, "1"]}})"), {"'sequence.feedback'", "a list of whole numbers"});
  check_error(parsing(R"({"sequence": {"start": 1}})"), {"'sequence.start' is 1", "a list of whole numbers"});
  check_error(parsing(R"({"sample_rate_hz": "100"})"), {"'sample_rate_hz' is \"100\"", "a number"});
  check_error(parsing(R"({"sample_rate_hz": null})"), {"'sample_rate_hz' is null", "a number"});
  check_error(parsing(R"({"body": {"mass_kg": true}})"), {"'body.mass_kg' is true", "a number"});
  for (const char* value : {"\"low\"", "[0.1]", "[0.1, 0.2, 0.3]", "[0.1, \"x\"]"}) {
    check_error(parsing(std::string(R"({"sensor_noise_deg": )") + value + "}"),
                {"'sensor_noise_deg'", "a number or [low, high]"});
  }
}

TEST_CASE("values that no protocol may have are refused with the file's name") {
  check_error(parsing(R"({"sample_rate_hz": -1})"), {"my.json: ", "sample_rate"});
  check_error(parsing(R"({"sensor_noise_deg": [0.1, 0.01]})"), {"my.json: ", "sensor_noise"});
}

TEST_CASE("protocols are loaded by name or from a file") {
  CHECK(to_json(load_protocol("default")) == to_json(sim::default_protocol()));
  CHECK(to_json(load_protocol("short")) == to_json(sim::short_protocol()));
  const TemporaryFolder folder;
  const auto path = write_text(folder / "p.json", to_json(tiny_protocol()));
  CHECK(to_json(load_protocol(path.string())) == to_json(tiny_protocol()));
  check_error([] { load_protocol("shrot"); }, {"shrot", "neither a built-in protocol nor a file", "default, short"});
  const auto bad = write_text(folder / "bad.json", "{");
  check_error([&] { load_protocol(bad.string()); }, {bad.c_str(), "line 1"});
}
