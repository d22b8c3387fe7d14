// decid fit, as scripts call it.
#include <algorithm>
#include <thread>

#include "sim/body_model.hpp"
#include "tests/tools/decid/run.hpp"

using namespace decid::test;
using Json = nlohmann::json;

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
  CHECK(left_out["blocks"] == 621);  // the body is still in the other nine
  CHECK(left_out["standard_error"].get<double>() > 0);
  CHECK(left_out["effective_parameters"].get<double>() > 7);
  CHECK(contains(read_text(folder / "r.html"), "\"log_density\""));

  CHECK(run_decid(command + " --threads 1").out == result.out);
}

TEST_CASE("fit: ranges and priors of parameters") {
  const Folder folder;
  run_ok("simulate" + with_brief_protocol(folder) + "--nv 0.3 --seed 4 -o " + folder / "t.csv");
  const std::string known =
      " --range delay=0.05,0.2 --prior delay=0.12,0.01 --prior Kp=850,20 --range Kp_pass=100,250 --moved-before";
  const auto result = run_ok("fit --quiet --json" + with_brief_protocol(folder) + "--max-draws 8" + known + " " +
                             folder / "t.csv" + " --draws " + folder / "d.npz");
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
  run_ok("simulate" + with_brief_protocol(folder) + "--nv 0.3 --seed 4 -o " + folder / "t.csv");
  const auto result =
      run_ok("fit --quiet --json" + with_brief_protocol(folder) +
             "--max-draws 8 --fix Kp=880 --controller dec,dec2015 " + folder / "t.csv" + " -o " + folder / "o.json");
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
  run_ok("simulate" + with_brief_protocol(folder) + "--seed 4 -o " + folder / "t.csv");
  std::string files;
  for (int i = 0; i < 100; ++i) files += " " + folder / "t.csv";
  // Ctrl-C after a line of progress in the middle of drawing. A terminal has one every 0.2 s, a file every 10 s.
  write_text(folder / "fit.sh", "echo $$ >" + folder / "pid" +
                                    "; exec " DECID_PROGRAM " fit --threads 1 --max-draws 50" +
                                    with_brief_protocol(folder) + files + " -o " + folder / "o.json" + " --report " +
                                    folder / "r.html" + " >" + folder / "out");
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
  const auto result = run_ok("fit " + folder / "t.csv" + " --json" + with_brief_protocol(folder) +
                             "--mass 88.86 --height 1.8 " + "--max-draws 8 --truth " + truth);
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
