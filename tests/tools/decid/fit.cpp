// decid fit and decid compare, as scripts call them.

#include <algorithm>
#include <thread>

#include "sim/body_model.hpp"
#include "sim/protocol/protocol_json.hpp"
#include "tests/tools/decid/run.hpp"
#include "tools/report/comparison_page.hpp"

using namespace decid::test;
using Json = nlohmann::json;

namespace {

constexpr const char* small = " --starts 1 --simulations 6500 --max-draws 8 --seed 3";

/// Writes the tiny protocol to a file; returns its option.
std::string tiny(const Folder& folder) {
  write_text(folder / "tiny.json", brief_protocol);
  return " --protocol " + folder / "tiny.json" + " ";
}

}  // namespace

TEST_CASE("fit gives identify's keys and the posterior" * doctest::test_suite("slow")) {
  const Folder folder;
  run_ok("simulate --protocol short --nv 0.3 --seed 4 -o " + folder / "t.csv");
  const std::string command = "fit " + folder / "t.csv" + " --protocol short --max-draws 20 --json";
  const auto result =
      run_ok(command + " -o " + folder / "o.json" + " --draws " + folder / "d.npz" + " --report " + folder / "r.html");
  CHECK(result.out == read_text(folder / "o.json"));
  CHECK(Json::parse(result.out).at("other_answer").is_null());  // the network does not know this protocol
  const Json recording = Json::parse(result.out)["recordings"].at(0);
  const decid::sim::ParameterTable& table = decid::sim::single_pendulum().parameters;
  REQUIRE(recording["parameters"].size() == table.size());
  for (std::size_t p = 0; p < table.size(); ++p) {
    const Json& parameter = recording["parameters"][p];
    const decid::sim::ParameterInfo& info = table[p];
    CHECK(parameter["name"] == info.name);
    CHECK(parameter["unit"] == info.unit);
    CHECK(parameter["sd"].get<double>() > 0);
    CHECK(parameter["normalized"].is_null() != info.per_mgh);
    CHECK(parameter["normalized_interval90"].is_null() != info.per_mgh);
    double before = info.low;
    for (const double limit :
         {parameter["interval90"][0].get<double>(), parameter["interval50"][0].get<double>(),
          parameter["interval50"][1].get<double>(), parameter["interval90"][1].get<double>(), info.high}) {
      CHECK(limit >= before);
      before = limit;
    }
    // The mean of the draws: of these few it lies within what holds nine tenths of them.
    CHECK(parameter["value"].get<double>() >= parameter["interval90"][0].get<double>());
    CHECK(parameter["value"].get<double>() <= parameter["interval90"][1].get<double>());
    CHECK(recording["diagnostics"]["rhat"][info.name].get<double>() > 0.9);
    CHECK(recording["diagnostics"]["effective_draws"][info.name].get<double>() > 0.0);
    CHECK(near(recording["correlations"][p][p].get<double>(), 1.0, 1e-12));
  }
  CHECK(recording["diagnostics"]["chains"] == 8);
  CHECK(recording["diagnostics"]["draws"] == 160);
  CHECK(recording["diagnostics"]["agreed"].is_boolean());
  CHECK(recording["fit"]["answer"] == "posterior");
  CHECK(recording["fit"]["variance_accounted_for"].get<double>() > 0);
  CHECK(recording["gain"]["sd"].get<double>() > 0);
  CHECK(contains(read_text(folder / "d.npz"), "sensor_noise_deg.npy"));
  CHECK(recording["sensor_noise_deg"]["of_samples"].get<double>() > 0);
  const Json& check = recording["predictive_check"];
  CHECK(check["standing"].get<int>() <= check["trials"].get<int>());
  REQUIRE(check["figures"].size() == 8);
  for (const Json& figure : check["figures"]) {
    CHECK((figure["p"].get<double>() > 0.0 && figure["p"].get<double>() <= 1.0));
    CHECK(figure["simulated_interval90"][0].get<double>() <= figure["simulated"].get<double>());
    CHECK(figure["simulated"].get<double>() <= figure["simulated_interval90"][1].get<double>());
  }
  const Json& left_out = recording["log_predictive_density"];
  CHECK(left_out["blocks"] == 630);
  CHECK(left_out["standard_error"].get<double>() > 0);
  CHECK(left_out["effective_parameters"].get<double>() > 7);
  CHECK(contains(read_text(folder / "r.html"), "\"log_density\""));

  CHECK(run_decid(command + " --threads 1").out == result.out);
}

TEST_CASE("fit: ranges and priors of parameters") {
  const Folder folder;
  run_ok("simulate" + tiny(folder) + "--nv 0.3 --seed 4 -o " + folder / "t.csv");
  const std::string known =
      " --range delay=0.05,0.2 --prior delay=0.12,0.01 --prior Kp=850,20 --range Kp_pass=100,250 --moved-before";
  const auto result = run_ok("fit --quiet --json" + tiny(folder) + "--max-draws 8" + known + " " + folder / "t.csv" +
                             " --draws " + folder / "d.npz");
  const Json all = Json::parse(result.out), recording = all["recordings"].at(0);
  const decid::sim::ParameterTable& table = decid::sim::single_pendulum().parameters;
  for (std::size_t p = 0; p < table.size(); ++p) {
    const Json& parameter = recording["parameters"][p];
    const std::string name = parameter["name"];
    CAPTURE(name);
    const Json range = name == "delay"     ? Json{0.05, 0.2}
                       : name == "Kp_pass" ? Json{100.0, 250.0}
                                           : Json{table[p].low, table[p].high};
    const Json prior = name == "delay" ? Json{{"mean", 0.12}, {"sd", 0.01}}
                       : name == "Kp"  ? Json{{"mean", 850.0}, {"sd", 20.0}}
                                       : Json(nullptr);
    CHECK(parameter["range"] == range);
    CHECK(parameter.value("prior", Json(nullptr)) == prior);
    CHECK(parameter["interval90"][0].get<double>() >= range[0].get<double>());
    CHECK(parameter["interval90"][1].get<double>() <= range[1].get<double>());
  }
  const std::vector<std::string> options = all["options"];
  for (const char* option : {"--range delay=0.05,0.2 Kp_pass=100,250", "--prior delay=0.12,0.01 Kp=850,20"})
    CHECK(std::ranges::count(options, option) == 1);
  CHECK(std::ranges::count_if(options, [](const std::string& o) { return o.starts_with("--moved-before"); }) == 1);
  CHECK(recording["slow_noise_deg"]["value"].get<double>() > 0.0);
  CHECK(recording["slow_noise_deg"]["memory_s"].get<double>() > 0.0);
  CHECK(recording["slow_noise_deg"].size() == 2);
  CHECK(recording["diagnostics"]["rhat"].size() == 10);
  CHECK(recording["diagnostics"]["effective_draws"].size() == 10);
  CHECK(contains(read_text(folder / "d.npz"), "slow_noise_deg.npy"));
}

// Guards the way of several controllers through sampling, checks, comparison and output.
TEST_CASE("fit: controllers are compared, and parameters are fixed" * doctest::test_suite("slow")) {
  const Folder folder;
  run_ok("simulate" + tiny(folder) + "--nv 0.3 --seed 4 -o " + folder / "t.csv");
  const auto result =
      run_ok("fit --quiet --json" + tiny(folder) + "--max-draws 8 --fix Kp=880 --controller dec,dec2015 " +
             folder / "t.csv" + " -o " + folder / "o.json");
  const Json all = Json::parse(result.out), recording = all["recordings"].at(0);
  CHECK(all["controller"] == "dec");
  CHECK(recording["parameters"][0]["fixed"] == true);
  CHECK(recording["parameters"][0]["value"] == 880.0);
  CHECK(recording["parameters"][0]["sd"] == 0.0);
  CHECK(recording["parameters"][1]["sd"].get<double>() > 0.0);
  const Json& controllers = recording["controllers"];
  REQUIRE(controllers.size() == 2);
  CHECK(controllers[0]["controller"] == "dec");
  CHECK(controllers[1]["controller"] == "dec2015");
  double weights = 0.0, best = -1.0;
  for (const Json& one : controllers) {
    weights += one["weight"].get<double>();
    best = std::max(best, one["difference"].get<double>());
    CHECK(one["difference_standard_error"].get<double>() >= 0.0);
  }
  CHECK(near(weights, 1.0, 1e-9));
  CHECK(best == 0.0);
  CHECK(near(controllers[0]["log_predictive_density"].get<double>(),
             recording["log_predictive_density"]["value"].get<double>(), 1e-12));
  CHECK(controllers[1]["parameters"].size() == decid::sim::dec2015().parameters.size());
  CHECK(controllers[1]["parameters"][0]["sd"] == 0.0);  // fixed for both
  CHECK(controllers[1]["predictive_check"]["figures"].size() == 8);
}

TEST_CASE("fit: controllers are summed over recordings, and a journal of other controllers is refused") {
  const Folder folder;
  write_text(folder / "tiny.json", brief_protocol);
  const std::string protocol = " --protocol " + folder / "tiny.json";
  for (const char* seed : {"1", "2"})
    run_ok("simulate --quiet" + protocol + " --seed " + seed + " -o " + folder / seed + ".csv");
  const std::string files = folder / "1.csv" + " " + folder / "2.csv" + " ",
                    fit = "fit --quiet --max-draws 8" + protocol + " " + files;
  const auto result = run_ok(fit + "--controller dec,ic -o " + folder / "o.json");
  const Json all = read_json(folder / "o.json"), sums = all["controller_comparison"];
  CHECK(contains(result.out, "Controllers over 2 recordings"));
  CHECK(result.out.find("Best controller over 2 recordings: ") < result.out.find("1.csv ("));
  CHECK(sums["recordings"] == 2);
  REQUIRE(sums["controllers"].size() == 2);
  std::size_t best_in = 0;
  double best = -1e9;
  for (std::size_t k = 0; k < 2; ++k) {
    const Json& one = sums["controllers"][k];
    double sum = 0.0;
    for (const Json& recording : all["recordings"])
      sum += recording["controllers"][k]["log_predictive_density"].get<double>();
    CHECK(near(one["log_predictive_density"].get<double>(), sum, 1e-12));
    best_in += one["best_in"].get<std::size_t>();
    best = std::max(best, one["difference"].get<double>());
  }
  CHECK(best_in == 2);
  CHECK(best == 0.0);

  // A missing recording leaves the others' results in the journal.
  const std::string some = fit + folder / "none.csv" + " -o " + folder / "j.json";
  CHECK(run_decid(some).code == 2);
  check_refused(some + " --resume --controller dec,ic", "j.json.journal");
  CHECK(run_decid(some + " --resume --controller dec").code == 2);
  CHECK_FALSE(read_json(folder / "j.json").contains("controller_comparison"));
}

TEST_CASE("fit refuses invalid controllers and fixed values, by the option") {
  const Folder folder;
  run_ok("simulate --seed 4 -o " + folder / "t.csv");
  const std::string fit = "fit " + folder / "t.csv" + " ";
  check_refused(fit + "--controller pid", "--controller");
  check_refused(fit + "--controller dec,ic,dec", "--controller");
  check_refused(fit + "--fix Kp=-1", "--fix");
  check_refused(fit + "--fix Kp", "--fix");
  check_refused(fit + "--fix Kp=900 --range Kp=800,1000", "--fix");
  check_refused(fit + "--fix W=0.5", "--fix");
  check_refused(fit + "--controller dec,ic --fix gravity=0.5", "--fix");
  decid::sim::Protocol protocol = decid::sim::default_protocol();
  protocol.experiment.body_model = &decid::sim::independent_channels();
  write_text(folder / "ic.json", decid::sim::to_json(protocol));
  check_refused(fit + "--controller dec2015 --protocol " + folder / "ic.json", "has the controller 'ic'");
  // The default controller counts too, if the file names it.
  write_text(folder / "dec.json", R"({"controller": "dec"})");
  for (const char* others : {"ic", "dec2015,ic"})
    check_refused(fit + "--controller " + others + " --protocol " + folder / "dec.json", "has the controller 'dec'");
  check_refused("fit --frf t.csv --controller ic --protocol " + folder / "dec.json", "has the controller 'dec'");
}

TEST_CASE("fit: one bad recording of several does not stop the others, and quiet leaves the figures" *
          doctest::test_suite("slow")) {
  const Folder folder;
  run_ok("simulate --protocol short --seed 4 -o " + folder / "t.csv");
  write_text(folder / "bad.csv", "time,sway\n0,1\n0.01,x\n");
  // Can be read, but within the protocol nothing moves.
  std::string still = "time,sway\n";
  for (int k = 0; k < 7000; ++k) still += std::to_string(0.01 * k) + (k < 6500 ? ",0\n" : ",1\n");
  write_text(folder / "still.csv", still);
  const auto result = run_decid("fit --quiet --protocol short --max-draws 8 " + folder / "bad.csv" + " " +
                                folder / "still.csv" + " " + folder / "t.csv" + " -o " + folder / "o.json");
  CAPTURE(result.err);
  CHECK(result.code == 2);
  CHECK(contains(result.err, "bad.csv"));
  CHECK(contains(result.err, "still.csv, posterior: the recording is constant"));
  CHECK(contains(result.err, "2 of 3 recordings failed"));
  CHECK(contains(result.out, "bad.csv: not analysed"));
  CHECK(contains(result.out, "Kp_pass"));
  CHECK(contains(result.out, "predictive check, two-sided p: 0.05 to 0.2 Hz "));
  CHECK(contains(result.out, "the intervals may be too narrow"));  // the trial has no sensor noise
  const Json json = read_json(folder / "o.json");
  CHECK(json["body"]["assumed"] == true);
  CHECK(json["recordings"][0].contains("error"));
  CHECK(json["recordings"][1].contains("error"));
  CHECK(json["recordings"][2]["diagnostics"]["draws"] == 64);
}

// Guards that nothing drawn is lost.
TEST_CASE("fit: Ctrl-C keeps the draws" * doctest::test_suite("slow")) {
  const Folder folder;
  run_ok("simulate" + tiny(folder) + "--seed 4 -o " + folder / "t.csv");
  std::string files;
  for (int i = 0; i < 100; ++i) files += " " + folder / "t.csv";
  // Ctrl-C after a line of progress in the middle of drawing. A terminal has one every 0.2 s, a file every 10 s.
  write_text(folder / "fit.sh",
             "echo $$ >" + folder / "pid" + "; exec " DECID_PROGRAM " fit --threads 1 --max-draws 50" + tiny(folder) +
                 files + " -o " + folder / "o.json" + " --report " + folder / "r.html" + " >" + folder / "out");
  const int status = std::system(("err=" + folder / "err" + "; script -qefc 'sh " + folder / "fit.sh" +
                                  "' $err >/dev/null </dev/null & child=$!; " + "while kill -0 $child && ! { [ -s " +
                                  folder / "o.json.journal" + " ] && grep -q R-hat $err; }; do sleep 0.02; " +
                                  "done; kill -INT $(cat " + folder / "pid" + "); wait $child")
                                     .c_str());
  const std::string out = read_text(folder / "out"), err = read_text(folder / "err");
  CAPTURE(err);
  REQUIRE((WIFEXITED(status) && WEXITSTATUS(status) == 130));
  CHECK(contains(err, "decid wrote the draws until then; --resume continues"));
  CHECK(contains(err, " of 100 recordings, "));
  CHECK(std::filesystem::exists(folder / "o.json.journal"));
  CHECK(contains(err, ", drawing, R-hat "));
  CHECK(contains(out, "Body (assumed): "));  // its last line, printed before the end
  const Json recordings = read_json(folder / "o.json")["recordings"];
  CHECK((recordings.size() >= 1 && recordings.size() < 100));
  // The last recordings begun, one per thread, have some draws or none.
  std::size_t whole = 0;
  for (const Json& recording : recordings) {
    if (recording.contains("error")) continue;
    CHECK(recording["diagnostics"]["draws"].get<int>() <= 400);
    whole += recording["diagnostics"]["draws"] == 400 ? 1 : 0;
  }
  CHECK(whole + std::thread::hardware_concurrency() >= recordings.size());
  CHECK(contains(read_text(folder / "r.html"), "</html>"));
}

TEST_CASE("fit: a subject's body, and known parameters beside") {
  const Folder folder;
  const std::string truth = "Kp=850,Kd=250,Kp_pass=200,Kd_pass=100,Nv=0.3,theta=0.001,delay=0.1";
  run_ok("simulate --protocol short --seed 4 -o " + folder / "t.csv");
  const auto result = run_ok("fit " + folder / "t.csv" + " --json" + tiny(folder) + "--mass 88.86 --height 1.8 " +
                             "--max-draws 8 --truth " + truth);
  const Json recording = Json::parse(result.out)["recordings"][0];
  CHECK(recording["parameters"][0]["true"] == 850);
  const double mgh =
      recording["parameters"][0]["value"].get<double>() / recording["parameters"][0]["normalized"].get<double>();
  CHECK(near(mgh, 838.98, 1e-3));
}

TEST_CASE("fit: where chains disagree, the network's values have its intervals; sway of the other sign is not usable" *
          doctest::test_suite("slow")) {
  const Folder folder;
  run_ok("simulate --seed 7 --quiet -o " + folder / "t.csv");
  const auto first = [](const std::string& command) { return first_recording(command + " --json"); };
  const std::string golden = DECID_SOURCE_DIR "/tests/golden/0.2.0/";  // a network of trials of 4 s
  const std::string few = "fit --quiet --seed 6 --max-draws 8 ",
                    trial = golden + "trial.csv --model " + golden + "net.safetensors";
  const Json fitted = first(few + trial), identified = first("identify " + trial),  // too few draws to agree
      turned = first(few + folder / "t.csv" + " --invert sway");
  CHECK(fitted["fit"]["answer"] == "network");
  CHECK(fitted["diagnostics"]["agreed"] == false);
  for (std::size_t p = 0; p < fitted["parameters"].size(); ++p)
    for (const char* key : {"value", "sd", "interval50", "interval90", "normalized_interval90"})
      CHECK(fitted["parameters"][p].at(key) == identified["parameters"][p].at(key));
  CHECK(fitted["correlations"] == identified["correlations"]);
  CHECK(fitted["ood_score"] == identified["ood_score"]);
  CHECK(fitted["trust"] == "caution");
  CHECK(turned["trust"] == "not usable");
  CHECK(turned["ood_score"].get<double>() > 1.0);
}

TEST_CASE("calibrate: figures of trials, resumed as if never stopped" * doctest::test_suite("slow")) {
  const Folder folder;
  const std::string protocol = tiny(folder);
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
  const nlohmann::json own = run_json(call)["settings"];
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
      "offset_s": 0, "cycles": 1}})");
  const std::string options = " --trials 1 --max-draws 8 --json -o " + folder / "f.json";
  const std::string faults = "calibrate --faults --quiet --protocol " + folder / "p.json" + options;
  const auto first = run_ok(faults);
  CHECK(first.out == read_text(folder / "f.json"));
  const nlohmann::ordered_json made = nlohmann::ordered_json::parse(first.out);
  REQUIRE(made["conditions"].size() == 18);
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
  REQUIRE(again["conditions"].size() == 18);
  CHECK(again["conditions"][0]["usable"] == 77);
  CHECK(again["conditions"][5]["figures"] == made["conditions"][5]["figures"]);
  // A call that resumes says how many rows there are.
  const auto told = run_ok("calibrate --faults --protocol " + folder / "p.json" + options + " --resume");
  CHECK(told.err == "calibrate: resuming: " + folder / "f.json" + " has 18 of 18 rows\n");
  check_refused(faults + " --resume --seed 9", "seed is 9, and was 2026");
  check_refused(std::string(faults).replace(faults.find("--trials 1"), 10, "--trials 2") + " --resume",
                "trials is 2, and was 1");
  check_refused(faults + " --resume --model " DECID_SOURCE_DIR "/models/ideal.safetensors", "network is \"");
  check_refused(faults + " --resume --sensor-noise 0.03", "protocol.sensor_noise_deg is 0.03, and was 0.02");
  cut["conditions"][0]["size"] = 99;
  write_text(folder / "f.json", cut.dump());
  check_refused(faults + " --resume", "f.json: ");
  cut["conditions"] = nlohmann::ordered_json::object();
  write_text(folder / "f.json", cut.dump());
  check_refused(faults + " --resume", "f.json: ");
  write_text(folder / "f.json", "[]");
  check_refused(faults + " --resume", "f.json: ");
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

TEST_CASE("compare: the table, the JSON and the page say the same" * doctest::test_suite("slow")) {
  const Folder folder;
  const std::string protocol = tiny(folder), model = " --model " + folder / "m.safetensors" + " ";
  write_text(folder / "net.txt", "globalavgpool\nfc 7\n");
  run_ok("train --stream --stream-trials 40 --validation-trials 20 --epochs 1 --head point --quiet --architecture " +
         folder / "net.txt" + protocol + "-o " + folder / "m.safetensors");
  const auto result = run_ok("compare" + model + "--trials 2 --sensor-noise 0.02 --quiet --json --report " +
                             folder / "c.html" + " -o " + folder / "c.json" + small);
  const Json json = Json::parse(result.out);
  CHECK(json["trials"] == 2);
  REQUIRE(json["methods"].size() == 6);
  CHECK(json["methods"][0]["name"] == "network");
  CHECK(json["methods"][0]["simulations"] == 0);
  for (const Json& method : json["methods"]) {
    double sum = 0;
    for (const auto& [name, mse] : method["mse_per_parameter"].items()) sum += mse.get<double>();
    CHECK(near(method["mse"].get<double>(), sum / 7, 2e-15));  // another order of 7 numbers
    if (method["name"] != "posterior") CHECK(method["simulations"].get<double>() <= 6500);
    CHECK(method["seconds"].get<double>() > 0);
    const std::string name = method["name"];
    CHECK(method["error_per_standard_error"].is_number() ==
          (name == "iterative fit" || name == "iterative fit from network" || name == "posterior"));
  }
  CHECK(result.out == read_text(folder / "c.json"));
  // A study of the same model shows it, of another not.
  const std::string study =
      "study" + model + "--quiet --trials 20 --realisations 1 --sensor-noise 0 -o " + folder / "study";
  const auto studied = run_ok(study + " --comparison " + folder / "c.json");
  CHECK(contains(studied.out, "| iterative fit from network |"));
  const Json study_json = read_json(folder / "study/study.json");
  Json shown = json;  // without its call
  for (const char* key : {"arguments", "command", "decid", "inputs", "seed"}) shown.erase(key);
  CHECK(study_json["comparisons"] == Json::array({shown}));
  CHECK(contains(read_text(folder / "study/report.html"), "fit from network"));
  Json other = json;
  other["weights_sha256"] = "0";
  write_text(folder / "other.json", other.dump());
  check_refused(study + " --comparison " + folder / "other.json", "other.json");
  other.erase("methods");
  write_text(folder / "other.json", other.dump());
  check_refused(study + " --comparison " + folder / "other.json", "other.json");
  write_text(folder / "other.json", "{");
  check_refused(study + " --comparison " + folder / "other.json", "other.json");
  // On trials of a data set, which have their own noise; in words.
  run_ok("dataset" + protocol + "--quiet --count 2 --seed 77 -o " + folder / "d.npz");
  const std::string on_data = "compare" + model + "--trials 1 --quiet --data " + folder / "d.npz" + small;
  const auto said = run_ok(on_data);
  CHECK(contains(said.out, "d.npz"));
  CHECK(contains(said.out, "iterative fit from network"));
  // Whoever looks at the page needs nothing else.
  const std::string page = read_text(folder / "c.html");
  CHECK(contains(page, "fit from network"));
  CHECK_FALSE(contains(page, "src="));
}

TEST_CASE("errors are squared differences over the deviation, averaged") {
  using namespace decid;
  const std::vector<sim::Parameters> truth(2, sim::Parameters(7));
  std::vector<sim::Parameters> estimates = truth;
  const sim::Parameters stddev{2, 2, 2, 2, 2, 2, 2};
  estimates[0][1] = 4;   // 2 deviations
  estimates[1][1] = -2;  // 1
  const MethodFigures figures = compute_errors("a", "b", estimates, truth, stddev);
  CHECK(figures.mse_per_parameter[1] == 2.5);
  CHECK(figures.mse_per_parameter[0] == 0);
  CHECK(near(figures.mse, 2.5 / 7, 1e-15));
  // The two trials have 4/7 and 1/7: half their difference.
  CHECK(near(figures.mse_standard_error, 1.5 / 7, 2e-15));
}
