// decid stimulus and decid simulate with protocols of all kinds, as a user runs them.

#include <algorithm>
#include <cmath>
#include <set>

#include "sim/segments.hpp"
#include "tests/tools/decid/run.hpp"
#include "tools/report/stimulus_page.hpp"

using namespace decid::test;
using Json = nlohmann::json;
namespace sim = decid::sim;

namespace {

const std::string examples = std::string(DECID_SOURCE_DIR) + "/examples/";

sim::Protocol sines() {
  sim::Protocol protocol;
  protocol.name = "</script><b>";
  protocol.experiment.stimulus =
      sim::Sines{.components = {{.frequency_hz = 0.25, .amplitude_deg = 0.5},
                                {.frequency_hz = 2.0, .amplitude_deg = 0.125, .phase_deg = 30.0}},
                 .cycle_s = 20.0,
                 .cycles = 2,
                 .lead_in_s = 1.0,
                 .lead_out_s = 2.0};
  return protocol;
}

}  // namespace

TEST_CASE("stimulus: every kind of protocol, its page, and its JSON that makes the same again") {
  const Folder folder;
  for (const std::string protocol : {"default", "short", "measured.json", "sines.json", "raised_cosines.json"}) {
    CAPTURE(protocol);
    const std::string name = protocol.ends_with(".json") ? examples + protocol : protocol;
    const auto result = run_ok("stimulus --protocol " + name + " -o " + folder / "a.csv" + " --plot " +
                               folder / "a.html" + " --write-protocol " + folder / "a.json");
    REQUIRE(run_decid("stimulus --quiet --protocol " + folder / "a.json" + " -o " + folder / "b.csv" +
                      " --write-protocol " + folder / "b.json")
                .err.empty());
    CHECK(read_text(folder / "a.csv") == read_text(folder / "b.csv"));
    CHECK(read_text(folder / "a.json") == read_text(folder / "b.json"));
    CHECK(page_data(folder / "a.html")["tilt"]["x"].size() > 1000);
  }
}

TEST_CASE("stimulus: a long sequence is counted once, not at every sample") {
  // 6,560 states of 0.25 s: counted at each of the 164,000 samples, this test would take minutes.
  const Folder folder;
  write_text(
      folder / "long.json",
      R"({"sequence": {"feedback": [0,0,0,0,1,0,0,1], "start": [0,0,0,0,0,0,0,1], "offset_s": 0, "cycles": 1}})");
  const auto result = run_ok("stimulus --protocol " + folder / "long.json" + " -o " + folder / "a.csv" + " --plot " +
                             folder / "a.html");
  std::string header;
  CHECK(read_csv(folder / "a.csv", header).size() == 164'000);
  CHECK(page_data(folder / "a.html")["duration_s"] == 1640.0);
}

TEST_CASE("amplitude_spectrum: a sine's amplitude stands at its frequency") {
  const auto spectrum = decid::tools::amplitude_spectrum(sines());
  REQUIRE(near(spectrum.resolution_hz, 0.05, 1e-15));
  REQUIRE(spectrum.amplitude_deg.size() == 1001);
  for (std::size_t k = 0; k < spectrum.amplitude_deg.size(); ++k) {
    const double expected = k == 5 ? 0.5 : k == 40 ? 0.125 : 0.0;
    CHECK(std::abs(spectrum.amplitude_deg[k] - expected) < 1e-12);
  }
  // 1,009 is a prime: the cycle is shortened to 1,008 samples.
  sim::Protocol odd;
  odd.experiment.stimulus = sim::MeasuredTilt{.tilt_deg = std::vector<double>(1009, 0.0)};
  CHECK(decid::tools::amplitude_spectrum(odd).amplitude_deg.size() == 505);
}

TEST_CASE("stimulus_html: its data, escaped and thinned") {
  const Folder folder;
  const auto data_of = [&](const sim::Protocol& protocol) {
    return page_data(
        write_text(folder / "a.html", decid::tools::stimulus_html(protocol, "9.8.7", {"stimulus"})).string());
  };
  const Json data = data_of(sines());
  CHECK_FALSE(contains(read_text(folder / "a.html"), "</script><b>"));
  CHECK(data["name"] == "</script><b>");
  CHECK(data["kind"] == "sines");
  CHECK(data["version"] == "9.8.7");
  CHECK(data["duration_s"] == 43.0);
  CHECK(data["cycles"] == 2);
  CHECK(data["cycle_s"] == 20.0);
  CHECK(data["lead_in_s"] == 1.0);
  CHECK(data["tilt"]["x"].size() == 4300);
  CHECK(data["tilt"]["y"][0] == 0.0);
  CHECK(data["velocity"]["y"].size() == 4300);
  REQUIRE(data["spectrum"]["x"].size() == 2);
  CHECK(data["spectrum"]["x"][1] == 2.0);
  CHECK(data["spectrum"]["y"][0] == 0.5);
  // A sine's line between 100 samples a second: 2 pi f A, and 2% more at most where both are steepest.
  const double fastest = 2.0 * sim::pi * (0.25 * 0.5 + 2.0 * 0.125);
  CHECK(data["fastest_deg_s"].get<double>() < fastest);
  CHECK(data["fastest_deg_s"].get<double>() > 0.9 * fastest);

  sim::Protocol lengthy = sines();
  std::get<sim::Sines>(lengthy.experiment.stimulus).cycles = 150;
  const Json thin = data_of(lengthy);
  CHECK(thin["tilt"]["x"].size() <= 20'000);
  CHECK(thin["tilt"]["x"].size() > 10'000);
  const auto highest = [](const Json& list) { return std::ranges::max(list.get<std::vector<double>>()); };
  CHECK(highest(thin["tilt"]["y"]) == highest(data["tilt"]["y"]));
  CHECK(std::ranges::is_sorted(thin["tilt"]["x"].get<std::vector<double>>()));
}

TEST_CASE("simulate --model dip: columns, defaults, options of the hip") {
  const Folder folder;
  const auto first = run_ok("simulate --model dip --seed 7 -o " + folder / "a.csv");
  CHECK(contains(first.err, "hip"));
  std::string header;
  const auto rows = read_csv(folder / "a.csv", header);
  CHECK(header == "time,com_sway_deg,tilt_deg,leg_deg,trunk_deg");
  REQUIRE(rows.size() == 12100);
  // The centre of mass lies between leg and trunk, at its shares of both (77% and 23%), to the digits written.
  const sim::Segments s = sim::make_segments(sim::make_participant(sim::Body{}));
  const double trunk_share = s.trunk_mass_kg * s.trunk_com_m / (s.mass_kg() * s.com_height_m());
  double largest = 0.0;
  for (const std::vector<double>& row : rows) {
    REQUIRE(std::abs(row[1] - (1.0 - trunk_share) * row[3] - trunk_share * row[4]) < 1e-9);
    largest = std::max(largest, std::abs(row[1]));
  }
  CHECK(largest > 0.1);
  CHECK(largest <= 5.0);
  std::set<std::string> trials{read_text(folder / "a.csv")};  // each option of the hip changes the trial in its own way
  for (const char* option : {"kp 170", "kd 40", "kp-pass 110", "kd-pass 35", "nv 0.3", "theta 0.004", "delay 0.08"}) {
    run_ok(std::string("simulate --model dip --seed 7 --quiet --hip-") + option + " -o " + folder / "c.csv");
    CHECK_MESSAGE(trials.insert(read_text(folder / "c.csv")).second, option);
  }
  CHECK(run_decid("simulate --model dip --seed 8 --quiet -o " + folder / "d.csv").err.empty());
  CHECK(read_text(folder / "d.csv") != read_text(folder / "a.csv"));
  // The body is the protocol's.
  run_ok("simulate --model dip --protocol " + examples + "sines.json -o " + folder / "e.csv");
  CHECK(read_csv(folder / "e.csv", header).size() == 6000);
  write_text(folder / "band.json", R"({"gravity_dead_band_deg": 0.07})");
  CHECK(run_decid("simulate --model dip --protocol " + folder / "band.json" + " -o " + folder / "h.csv").code == 2);
  run_ok("simulate --model sip -o " + folder / "f.csv");
  run_ok("simulate -o " + folder / "g.csv");
  CHECK(read_text(folder / "f.csv") == read_text(folder / "g.csv"));
}
