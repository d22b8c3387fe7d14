// decid calibrate, as scripts call it.
#include <algorithm>

#include "posterior/density/priors.hpp"
#include "sim/body_model.hpp"
#include "tests/tools/decid/run.hpp"

using namespace decid::test;
using Json = nlohmann::json;

TEST_CASE("calibrate: figures of trials, resumed as if never stopped" * doctest::test_suite("slow")) {
  const Folder folder;
  const std::string protocol = with_brief_protocol(folder);
  const std::string command =
      "calibrate --quiet --sensor-noise 0.02 --max-draws 8 --groups 1 --json" + protocol + "-o " + folder / "c.json";
  run_ok(command + " --trials 1");
  const auto result = run_ok(command + " --trials 2 --resume");
  CHECK(result.out == read_text(folder / "c.json"));
  Json resumed = Json::parse(result.out);
  CHECK(resumed["calibration"]["trials"] == 2);
  CHECK(resumed["calibration"]["parameters"].size() == decid::sim::single_pendulum().parameters.size());
  CHECK(resumed["calibration"]["all"]["mse"].get<double>() < 1.0);
  for (const Json& trial : resumed["trials"])
    for (const Json& below : trial["below"]) CHECK((below.get<double>() >= 0.0 && below.get<double>() <= 1.0));
  const auto at_once = run_decid(command + "2 --trials 2");
  Json whole = Json::parse(at_once.out);
  for (Json* json : {&resumed, &whole})
    for (Json& trial : (*json)["trials"]) trial.erase("seconds");
  CHECK(resumed == whole);
  const auto open = run_ok(command + "3 --trials 1 --prior-start 0.1 --prior-gain 0.1");
  CHECK(Json::parse(open.out)["trials"][0]["truth"] == whole["trials"][0]["truth"]);
  CHECK(Json::parse(open.out)["trials"][0]["mean"] != whole["trials"][0]["mean"]);
  const auto parted = run_ok(command + " --trials 3 --resume --figure " + folder / "c.svg");
  CHECK(Json::parse(parted.out)["parts"]["damping_ratio"].size() == 3);
  CHECK(contains(read_text(folder / "c.svg"), "theta"));
  check_refused(command + " --trials 2 --resume", "3 trials");
  // In words: every parameter, the scores, and the parts that three trials make.
  const auto said = run_ok(std::string(command).replace(command.find(" --json"), 7, "") + " --trials 3 --resume");
  CHECK(said.out.starts_with("3 trials, chains of "));
  for (const decid::sim::ParameterInfo& info : decid::sim::single_pendulum().parameters)
    CHECK(contains(said.out, "| " + std::string(info.name) + " |"));
  CHECK(contains(said.out, "log score "));
  CHECK(contains(said.out, "| predicted variance | network | 90% coverage |"));
  const auto again = run_ok("rerun " + folder / "c.json");
  CHECK(contains(again.err, "computing times"));
  std::filesystem::create_symlink("c.json", folder / "same");
  check_refused(command + " --trials 3 --resume --figure " + folder / "same");
  check_refused(command + " --trials 2 --resume --seed 4", "seed is 4, and was 2026");
  // One from before the noise had a period of its own is of noise that repeats with the trial.
  std::string before = result.out;
  const std::string period = ",\n    \"period_s\": 32.0";
  REQUIRE(contains(before, period));
  before.erase(before.find(period), period.size());
  write_text(folder / "c.json", before);
  check_refused(command + " --trials 2 --resume", "protocol.vestibular_noise.period_s is 32.0, and was");
  std::string repeating = brief_protocol;
  repeating.insert(1, R"("vestibular_noise": {"period_s": "trial"}, )");
  write_text(folder / "tiny.json", repeating);
  CHECK(run_decid(command + " --trials 2 --resume").code == 0);
  write_text(folder / "c.json", "{}");
  check_refused(command + " --trials 2 --resume", "c.json");
}

TEST_CASE("calibrate: a table has fit's own priors, except for those that are given") {
  const std::string call =
      "calibrate --conditions short --only none --sensor-noise 0.02 --trials 1 --max-draws 8 --quiet --json";
  const decid::posterior::Priors fits;
  const nlohmann::json table = run_json(call), own = table["settings"], row = table["conditions"][0];
  // One trial: usable or not.
  CHECK(row["usable_figures"] == (row["usable"] == 1 ? row["figures"] : nlohmann::json()));
  CHECK(own["prior_start_s"] == fits.start_s);
  CHECK(own["prior_gain"] == fits.gain);
  CHECK(own["standing_s"] == fits.standing_s);
  const nlohmann::json given = run_json(call + " --prior-start 0 --prior-gain 0.05 --standing 2")["settings"];
  CHECK(given["prior_start_s"] == 0.0);
  CHECK(given["prior_gain"] == 0.05);
  CHECK(given["standing_s"] == 2.0);
}

TEST_CASE("calibrate: tables of faults and of conditions, resumed row by row" * doctest::test_suite("long")) {
  const Folder folder;
  write_text(folder / "p.json",
             R"({"sensor_noise_deg": 0.02, "recording": {"offset_deg": {"share": 0.3, "size": [0, 1]}},
      "sequence": {"feedback": [0, 0, -1, 1], "start": [0, 0, 0, 1], "state_s": 0.05, "amplitude_deg": 8,
      "offset_s": 0, "cycles": 2}})");  // 8 s: a gap of 2 s has to be less than half
  const std::string options = " --trials 1 --max-draws 8 --json -o " + folder / "f.json";
  const std::string faults = "calibrate --faults --quiet --protocol " + folder / "p.json" + options;
  const auto first = run_ok(faults);
  CHECK(first.out == read_text(folder / "f.json"));
  const nlohmann::ordered_json made = nlohmann::ordered_json::parse(first.out);
  REQUIRE(made["conditions"].size() == 19);
  for (const auto& row : made["conditions"]) {
    CHECK(row["trials"] == 1);
    CHECK(row["usable"].get<int>() + row["caution"].get<int>() + row["not_usable"].get<int>() == 1);
    CHECK(row["figures"].is_null() == (row["condition"] == "double_pendulum"));
  }
  // Rows that stand are not fitted again.
  nlohmann::ordered_json cut = made;
  cut["conditions"].erase(cut["conditions"].begin() + 1, cut["conditions"].end());
  cut["conditions"][0]["usable"] = 77;
  write_text(folder / "f.json", cut.dump());
  const auto resumed = run_ok(faults + " --resume");
  const auto again = nlohmann::ordered_json::parse(resumed.out);
  REQUIRE(again["conditions"].size() == 19);
  CHECK(again["conditions"][0]["usable"] == 77);
  CHECK(again["conditions"][5]["figures"] == made["conditions"][5]["figures"]);
  // A call that resumes says how many rows there are.
  const auto told = run_ok("calibrate --faults --protocol " + folder / "p.json" + options + " --resume");
  CHECK(told.err == "calibrate: resuming: " + folder / "f.json" + " has 19 of 19 rows\n");
  check_refused(faults + " --resume --seed 9", "seed is 9, and was 2026");
  check_refused(std::string(faults).replace(faults.find("--trials 1"), 10, "--trials 2") + " --resume",
                "trials is 2, and was 1");
  check_refused(faults + " --resume --model " DECID_SOURCE_DIR "/models/ideal.safetensors", "network is \"");
  check_refused(faults + " --resume --sensor-noise 0.03", "protocol.sensor_noise_deg is 0.03, and was 0.02");
  cut["conditions"][0]["size"] = 99;
  write_text(folder / "f.json", cut.dump());
  check_refused(faults + " --resume", "f.json: has other rows");
  cut["conditions"] = nlohmann::ordered_json::object();
  write_text(folder / "f.json", cut.dump());
  check_refused(faults + " --resume", "f.json: has rows that this version does not read");
  write_text(folder / "f.json", "[]");
  check_refused(faults + " --resume", "f.json: is not a table of decid calibrate");
  const auto table = run_ok("calibrate --conditions " + folder / "p.json" + " --trials 1 --max-draws 8 --quiet");
  CHECK(std::count(table.out.begin(), table.out.end(), '\n') == 4);  // two lines of the header, none, offset_deg
  CHECK(contains(table.out, "| offset_deg |"));
}

TEST_CASE("calibrate: another network's answers take the place of the first one's" * doctest::test_suite("long")) {
  const Folder folder;
  const std::string command =
      "calibrate --quiet --sensor-noise 0.02 --max-draws 8 --trials 1 --json -o " + folder / "c.json";
  const std::string model = " --model " DECID_SOURCE_DIR "/models/spectra.safetensors";
  const auto first = run_ok(command);
  const Json own = Json::parse(first.out), other = run_json(command + " --resume" + model);
  CHECK(own["network"] != other["network"]);
  CHECK(own["trials"][0]["mean"] == other["trials"][0]["mean"]);
  CHECK(own["trials"][0]["network"] != other["trials"][0]["network"]);
  CHECK(own["calibration"]["network_log_score"].is_number());
  CHECK(other["calibration"]["network_log_score"].is_null());  // it gives point estimates
  CHECK(run_json(command + " --resume") == own);
  check_refused(command + "2 --protocol short" + model);
}
