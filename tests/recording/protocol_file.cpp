// Protocols in files: by name or path, named after the file, and what people may not write in them.
#include "recording/protocol_file.hpp"

#include "sim/protocol/protocol_json.hpp"
#include "tests/helpers.hpp"
#include "tests/sim/tiny_protocol.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

TEST_CASE("protocols are loaded by name or from a file") {
  CHECK(to_json(load_protocol("default")) == to_json(sim::default_protocol()));
  CHECK(to_json(load_protocol("short")) == to_json(sim::short_protocol()));
  const TemporaryFolder folder;
  const auto path = write_text(folder / "p.json", to_json(tiny_protocol()));
  CHECK(to_json(load_protocol(path.string())) == to_json(tiny_protocol()));
  check_error([] { load_protocol("shrot"); }, Code::file_missing);
  const auto bad = write_text(folder / "bad.json", "{");
  check_error([&] { load_protocol(bad.string()); }, Code::setting_malformed, "line 1");
}

TEST_CASE("protocols: a controller by name, which a file must not contradict") {
  for (const char* name : {"default", "short"}) {
    const sim::Protocol protocol = load_protocol(name, nullptr, nullptr, "ic");
    CHECK(protocol.experiment.body_model == &sim::independent_channels());
    CHECK(protocol.samples() == load_protocol(name).samples());
  }
  const TemporaryFolder folder;
  const std::string none = write_text(folder / "none.json", "{}").string(),
                    dec = write_text(folder / "dec.json", R"({"controller": "dec"})").string(),
                    lab = write_text(folder / "lab.json", R"({"controller": "dec2015"})").string();
  const auto model = [](const std::string& file, const std::string& controller) {
    return load_protocol(file, nullptr, nullptr, controller).experiment.body_model;
  };
  CHECK(model(none, "") == &sim::single_pendulum());
  CHECK(model(none, "ic") == &sim::independent_channels());
  CHECK(model(lab, "") == &sim::dec2015());
  CHECK(model(lab, "dec2015") == &sim::dec2015());
  CHECK(model(dec, "dec") == &sim::single_pendulum());
  check_error([&] { model(lab, "ic"); }, Code::setting_conflict, "lab.json");
  check_error([&] { model(dec, "ic"); }, Code::setting_conflict, "dec.json");
  check_error([&] { model(none, "pid"); }, Code::setting_unknown, "dec2015");
}

TEST_CASE("a file without a name is named after itself") {
  const TemporaryFolder folder;
  CHECK(load_protocol(write_text(folder / "my exp.v2.json", "{}").string()).name == "my exp.v2");
  CHECK(load_protocol(write_text(folder / "a.json", R"({"name": "b"})").string()).name == "b");
  check_error([&] { load_protocol(write_text(folder / "mine.json", R"({"sample_rate_hz": -1})").string()); },
              Code::setting_out_of_range, "mine.json");
}

TEST_CASE("implausible protocols: refused in files that people write, read from data sets and models") {
  const TemporaryFolder folder;
  const auto check = [&](const std::string& text, Code code, std::string_view fact = {}) {
    const auto path = write_text(folder / "p.json", text);
    check_error([&] { load_protocol(path.string()); }, code, fact);
    CHECK_NOTHROW(sim::protocol_from_json(text, "a model from before"));
  };
  check(R"({"name": "a\u001b[2Jb"})", Code::setting_malformed, "byte 2");
  check(R"({"body": {"mass_kg": 86.283, "com_height_m": 0.99119, "inertia_kgm2": 80}})", Code::setting_out_of_range,
        "inertia_kgm2");
  std::string ramp = "0";
  for (int k = 1; k <= 1000; ++k) ramp += ", " + std::to_string(0.04 * k);
  check(R"({"measured": {"cycles": 3, "tilt_deg": [)" + ramp + "]}}", Code::setting_out_of_range, "tilt_deg");
}

TEST_CASE("the files in examples/ can be loaded") {
  const std::string folder = std::string(DECID_SOURCE_DIR) + "/examples/";
  CHECK(to_json(load_protocol(folder + "default.json")) == to_json(sim::default_protocol()));
  CHECK(to_json(load_protocol(folder + "short.json")) == to_json(sim::short_protocol()));
  // The published table of positions, at its turning points, over the amplitude.
  sim::Protocol comtest = load_protocol(folder + "comtest.json");
  const sim::Stimulus published = sim::make_stimulus(comtest.experiment);
  for (const auto& [ms, deg] : {std::pair{1970, 0.0},
                                {57100, 0.27679},
                                {57600, 0.05357},
                                {58600, 0.38839},
                                {59100, 0.5},
                                {59350, 0.38839},
                                {60600, 0.27679},
                                {61970, 0.0}})
    CHECK(within(published.tilt_at(ms) / sim::rad_per_deg * 225.0 / 224.0, deg, 1e-5));
  comtest.name = "short";
  comtest.sequence().offset_s = 0.0;
  CHECK(to_json(comtest) == to_json(sim::short_protocol()));
  CHECK(load_protocol(folder + "measured.json").duration_s() == 25.0);
  CHECK(load_protocol(folder + "sines.json").duration_s() == 60.0);
  CHECK(load_protocol(folder + "raised_cosines.json").duration_s() == 62.0);
  CHECK(load_protocol(folder + "seven_sines.json").duration_s() == 120.0);
  // All conditions, and bodies on either side of the default one.
  const sim::Protocol laboratory = load_protocol(folder + "laboratory.json");
  CHECK(to_json(laboratory.ideal()) == to_json(sim::default_protocol()));
  for (const sim::Severity& severity : laboratory.conditions.severity) CHECK(severity.fraction > 0.0);
  CHECK(laboratory.heights.low < 1.0);
  CHECK(laboratory.heights.high > 1.0);
  sim::Protocol people = load_protocol(folder + "people.json");
  CHECK(people.name == "people");
  CHECK(people.standing_s == 10.0);
  people.standing_s = 0.0;
  people.name = laboratory.name;
  CHECK(to_json(people) == to_json(laboratory));
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) files += entry.path().extension() == ".json";
  CHECK(files == 9);
}
