// decid export controller: whose body the exported gains are for.

#include <array>
#include <filesystem>

#include "base/text.hpp"
#include "sim/protocol/protocol.hpp"
#include "sim/segments.hpp"
#include "tests/tools/decid/run.hpp"

namespace decid {
namespace {

using namespace test;
using Json = nlohmann::json;

constexpr double rounding = 1e-12;
const sim::Body person = sim::make_body(sim::make_segments({.mass_kg = 70.0, .height_m = 1.75}));
/// Nearly of a person's build. Its m g h is a twentieth of the default body's.
constexpr sim::Body robot{.mass_kg = 7.2, .com_height_m = 0.6, .inertia_kgm2 = 3.1};

Json body_json(const sim::Body& body) {
  return {{"mass_kg", body.mass_kg}, {"com_height_m", body.com_height_m}, {"inertia_kgm2", body.inertia_kgm2}};
}

/// Well within what stands, with a short delay, which a small body needs.
sim::Parameters gains(const sim::Body& body) {
  const double mgh = body.mgh();
  return {0.9 * mgh, 0.3 * mgh, 0.25 * mgh, 0.12 * mgh, 0.15, 0.0016, 0.05};
}

Json parameters_json(const sim::Parameters& values) {
  const sim::ParameterTable& table = sim::single_pendulum().parameters;
  Json parameters = Json::array();
  for (std::size_t i = 0; i < table.size(); ++i) parameters.push_back({{"name", table[i].name}, {"value", values[i]}});
  return parameters;
}

/// Writes a result as `decid identify` would for this body.
void write_result(const std::string& path, const std::optional<sim::Body>& body, const sim::Parameters& values) {
  Json result{{"recordings", {{{"trust", "usable"}, {"parameters", parameters_json(values)}}}}};
  if (body) result["body"] = body_json(*body);
  write_text(path, result.dump());
}

void write_protocol(const std::string& path, const sim::Body& body) {
  write_text(path, Json{{"name", "other"}, {"body", body_json(body)}}.dump());
}

/// The six gains, times and thresholds that a source says were identified, and what its header says of the body.
struct Exported {
  std::array<double, 6> values{};
  std::string header;

  bool has(const std::string& name, double value) const {
    return header.find("#define C_" + name + " " + format("%.17g", value)) != std::string::npos;
  }
};
Exported exported(const Folder& folder, const std::string& options) {
  const auto run = run_ok("export controller --name c --quiet " + options + " -o " + folder / "c");
  Exported found;
  const std::string source = read_text(folder / "c/c.c"), start = "c_identified = {";
  const std::size_t at = source.find(start);
  REQUIRE(at != std::string::npos);
  std::istringstream list(source.substr(at + start.size()));
  for (double& value : found.values) {
    char comma = 0;
    list >> value >> comma;
  }
  found.header = read_text(folder / "c/c.h");
  return found;
}

/// Gains times ratio; threshold and delay as they are.
void check_gains(const Exported& found, const sim::Parameters& from, double ratio) {
  for (const std::size_t i : {0U, 1U, 2U, 3U}) CHECK(near(found.values[i], ratio * from[i], rounding));
  CHECK(found.values[4] == from[sim::Theta]);
  CHECK(found.values[5] == from[sim::Delay]);
}

}  // namespace

TEST_CASE("export controller: a refused parameter is answered with options that the command has") {
  const Folder folder;
  const Result refused = run_decid("export controller --weight 0.1 -o " + folder / "c");
  CHECK(refused.code == 2);
  CHECK(contains(refused.err, "--delay"));
  CHECK_FALSE(contains(refused.err, "--nv"));
}

TEST_CASE("export controller: a protocol of another body than the result's is refused") {
  const Folder folder;
  const std::string result = folder / "r.json", other = folder / "robot.json", own = folder / "person.json";
  write_result(result, person, gains(person));
  write_protocol(other, robot);
  write_protocol(own, person);
  check_refused("export controller " + result + " --protocol " + other + " -o " + folder / "c", "7.2 kg at 0.6 m");
  check_refused("export controller " + result + " --protocol short -o " + folder / "c");
  CHECK_FALSE(std::filesystem::exists(folder / "c"));
  for (const std::string& options : {std::string(), " --protocol " + own}) {
    const Exported found = exported(folder, result + options);
    check_gains(found, gains(person), 1.0);
    CHECK(found.has("MASS_KG", person.mass_kg));
    CHECK(found.has("COM_HEIGHT_M", person.com_height_m));
    CHECK(found.has("INERTIA_KGM2", person.inertia_kgm2));
    CHECK(found.has("MGH_NM_RAD", person.mgh()));
  }
  // To the digits that are printed it is the same body.
  sim::Body rounded = person;
  rounded.mass_kg = 1e-3 * std::round(1e3 * rounded.mass_kg);
  write_protocol(own, rounded);
  CHECK(exported(folder, result + " --protocol " + own).has("MASS_KG", person.mass_kg));
}

TEST_CASE("export controller: gains are scaled to another body by m g h, and that body has to stand") {
  const Folder folder;
  const std::string result = folder / "r.json", other = folder / "robot.json";
  write_result(result, person, gains(person));
  write_protocol(other, robot);
  const double ratio = robot.mgh() / person.mgh();
  const Exported scaled = exported(folder, result + " --scale-to " + other);
  check_gains(scaled, gains(person), ratio);
  CHECK(scaled.has("MASS_KG", robot.mass_kg));
  CHECK(scaled.has("INERTIA_KGM2", robot.inertia_kgm2));
  CHECK(scaled.has("MGH_NM_RAD", robot.mgh()));

  // The inertia is computed from the result's build unless an option gives it.
  const Exported told = exported(folder, result + " --protocol short --mass 7.2 --com-height 0.6");
  check_gains(told, gains(person), ratio);
  const double inertia =
      person.inertia_kgm2 * (7.2 / person.mass_kg) * (0.6 / person.com_height_m * (0.6 / person.com_height_m));
  const std::string define = "#define C_INERTIA_KGM2 ";
  CHECK(near(std::stod(told.header.substr(told.header.find(define) + define.size())), inertia, rounding));
  CHECK(exported(folder, result + " --mass 7.2 --com-height 0.6 --inertia 3.1").has("INERTIA_KGM2", 3.1));
  // Gains on the command line are for the body of --scale-to.
  CHECK(exported(folder, result + " --scale-to " + other + " --kp 40").values[0] == 40.0);

  sim::Parameters late = gains(person);
  late[sim::Delay] = 0.24;  // far too late for a body of a tenth of the height
  write_result(folder / "late.json", person, late);
  const std::string small = " --mass 2 --com-height 0.1";
  check_refused("export controller " + folder / "late.json" + small + " -o " + folder / "n");
  CHECK_FALSE(std::filesystem::exists(folder / "n"));
}

TEST_CASE("export controller: --recording needs a result") {
  const Folder folder;
  check_refused("export controller --recording 3 -o " + folder / "out", "--recording: ");
}

TEST_CASE("export controller: a recording is neither a result nor a protocol") {
  const Folder folder;
  write_text(folder / "t.csv", "time,sway_deg\n0,1\n");
  write_result(folder / "r.json", person, gains(person));
  const std::string call = "export controller -o " + folder / "n" + " ";
  check_refused(call + folder / "t.csv", "decid identify -o");
  check_refused(call + folder / "r.json" + " --scale-to " + folder / "t.csv", "give a protocol");
}

TEST_CASE("export controller: a recording of a study has the gains of its own body") {
  const Folder folder;
  Json result{{"body", body_json(sim::Body{})}, {"recordings", Json::array()}};
  result["body"]["assumed"] = true;
  for (const sim::Body& body : {person, robot})
    result["recordings"].push_back(
        {{"trust", "usable"}, {"body", body_json(body)}, {"parameters", parameters_json(gains(body))}});
  write_text(folder / "r.json", result.dump());
  write_protocol(folder / "robot.json", robot);
  const Exported own = exported(folder, folder / "r.json" + " --recording 2");
  check_gains(own, gains(robot), 1.0);
  CHECK(own.has("MASS_KG", robot.mass_kg));
  check_gains(exported(folder, folder / "r.json" + " --scale-to " + folder / "robot.json"), gains(person),
              robot.mgh() / person.mgh());
}

TEST_CASE("export controller: a loop that is unstable, and falls only after the protocol, is refused") {
  const Folder folder;
  const std::string command = "export controller --quiet -o " + folder / "c";
  CHECK(run_ok(command).err.empty());
  // A lean grows 30 times in 400 s: the simulator's step adds to the delay, at whose limit this is.
  CHECK(run_ok(command + " --delay 0.235").err.empty());
  // A step of 10 ms adds as much.
  CHECK(run_ok(command + " --delay 0.22 --step 0.01").err.empty());
  std::filesystem::remove_all(folder / "c");
  for (const char* options : {" --delay 0.24", " --delay 0.235 --step 0.01"}) {
    check_refused(command + options, "unstable");
    CHECK_FALSE(std::filesystem::exists(folder / "c"));
  }
  const auto forced = run_ok(command + " --delay 0.24 --force --json --name c");
  CHECK(contains(forced.err, "unstable"));
  const Json json = Json::parse(forced.out);
  CHECK(json["stable"] == false);
  CHECK(json["delay_margin_s"] == 0.0);
  CHECK(json["gain_margin"] == Json{1.0, 1.0});
  CHECK(contains(read_text(folder / "c/c.h"), "#define C_IS_STABLE 0\n"));
}

TEST_CASE("export controller: margins and the peak torque, in the JSON and the header") {
  const Folder folder;
  const std::string command = "export controller --name c -o " + folder / "c";
  const auto json = run_json(command + " --json");
  CHECK(json["stable"] == true);
  CHECK(json["body"]["mass_kg"] == sim::Body{}.mass_kg);
  CHECK(json["body"]["assumed"] == true);
  CHECK(run_json(command + " --mass 70 --com-height 1 --json")["body"]["assumed"] == false);
  CHECK_FALSE(contains(run_ok(command).err, "narrow"));
  const double gain_low = json["gain_margin"][0];
  const sim::Parameters middle = sim::single_pendulum().parameters.middle();
  CHECK(contains(run_ok(command + format(" --kp %.17g", 1.05 * gain_low * middle[sim::Kp])).err, "narrow"));
  const double delay_s = sim::single_pendulum().parameters.middle()[sim::Delay];
  const double margin_s = json["delay_margin_s"];
  // The margin is what --delay may grow by; a step of 10 ms instead of 1 takes 9 ms of it.
  CHECK(near(run_json(command + format(" --delay %.17g --json", delay_s + 0.05))["delay_margin_s"].get<double>(),
             margin_s - 0.05, 1e-9));
  CHECK(near(run_json(command + " --step 0.01 --json")["delay_margin_s"].get<double>(), margin_s - 0.009, 1e-9));
  const sim::Parameters p = sim::single_pendulum().parameters.middle();
  CHECK(near(json["gain_margin"][0].get<double>(), 0.5 * (sim::Body{}.mgh() - p[sim::Kp_pass]) / p[sim::Kp], 1e-9));
  const double high = json["gain_margin"][1];
  const auto with_gain = [&](double factor) {
    return command + format(" --quiet --kp %.17g --kd %.17g", factor * p[sim::Kp], factor * p[sim::Kd]);
  };
  CHECK(run_ok(with_gain(0.99 * high)).code == 0);
  check_refused(with_gain(1.1 * high));

  run_ok(command);
  const std::string header = read_text(folder / "c/c.h");
  CHECK(contains(header, "#define C_IS_STABLE 1\n"));
  for (const auto& [name, value] : {std::pair{"DELAY_MARGIN_S", margin_s},
                                    {"GAIN_MARGIN_HIGH", high},
                                    {"PEAK_TORQUE_NM", json["peak_active_torque_nm"].get<double>()}})
    CHECK(contains(header, "#define C_" + std::string(name) + " " + format("%.17g", value)));
}

TEST_CASE("export controller: default gains are the middle of the ranges of the protocol's body") {
  const Folder folder;
  write_protocol(folder / "person.json", person);
  const sim::Parameters middle = sim::single_pendulum().parameters.middle();
  check_gains(exported(folder, "--protocol " + folder / "person.json"), middle, person.mgh() / sim::Body{}.mgh());
  check_gains(exported(folder, ""), middle, 1.0);
}

TEST_CASE("export controller: a result that does not say whose body it is for is not scaled") {
  const Folder folder;
  const std::string result = folder / "r.json";
  write_protocol(folder / "robot.json", robot);
  write_result(result, {}, gains(sim::Body{}));
  check_gains(exported(folder, result + " --protocol short"), gains(sim::Body{}), 1.0);
  for (const char* option : {"--protocol ", "--scale-to "})
    check_refused("export controller " + result + " " + option + folder / "robot.json" + " -o " + folder / "n",
                  "r.json");
  // decid identify without --mass and --height: only gains as they are, with a warning.
  write_result(result, sim::Body{}, gains(sim::Body{}));
  Json json = read_json(result);
  json["body"]["assumed"] = true;
  write_text(result, json.dump());
  CHECK(contains(run_ok("export controller --quiet " + result + " -o " + folder / "n").err, "whose body"));
  for (const std::string& options : {"--scale-to " + folder / "robot.json", std::string("--mass 7.2 --com-height 0.6")})
    check_refused("export controller " + result + " " + options + " -o " + folder / "n", "whose body");
  // A model for another body is for that body, also where nobody repeats it.
  json["body"].update(body_json(person));
  json["recordings"][0]["parameters"] = parameters_json(gains(person));
  write_text(result, json.dump());
  check_gains(exported(folder, result + " --scale-to " + folder / "robot.json"), gains(person),
              robot.mgh() / person.mgh());

  write_result(result, sim::Body{.mass_kg = 0.0}, gains(person));
  check_refused("export controller " + result + " --scale-to " + folder / "robot.json" + " -o " + folder / "n",
                "r.json");
}

TEST_CASE("simulate: default gains are the middle of the ranges of the protocol's body, as in data sets") {
  const Folder folder;
  write_protocol(folder / "person.json", person);
  const std::string protocol = " --protocol " + folder / "person.json";
  std::string options;
  const sim::ParameterTable& table = sim::single_pendulum().parameters;
  const double ratio = person.mgh() / sim::Body{}.mgh();
  for (const sim::ParameterInfo& info : table)
    options += " --" + info.option +
               format(" %.17g", info.scales_with_mgh ? 0.5 * (ratio * info.low + ratio * info.high) : info.middle());
  run_ok("simulate --quiet" + protocol + " -o " + folder / "a.csv");
  run_ok("simulate --quiet" + protocol + options + " -o " + folder / "b.csv");
  CHECK(read_text(folder / "a.csv") == read_text(folder / "b.csv"));
  run_ok("simulate --quiet" + options + " -o " + folder / "c.csv");
  CHECK(read_text(folder / "a.csv") != read_text(folder / "c.csv"));
  write_protocol(folder / "robot.json", robot);
  run_ok("simulate --quiet --delay 0.05 --protocol " + folder / "robot.json" + " -o " + folder / "d.csv");
}

}  // namespace decid
