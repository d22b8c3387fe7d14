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
    CHECK(parameter["normalized_interval90"].is_null() != info.scales_with_mgh);
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
  CHECK(check["figures"].size() == 8);
  for (const Json& figure : check["figures"]) {
    CHECK((figure["p"] > 0.0 && figure["p"] <= 1.0));
    CHECK(figure["simulated_interval90"][0] <= figure["simulated"]);
    CHECK(figure["simulated"] <= figure["simulated_interval90"][1]);
  }
  const Json& left_out = recording["log_predictive_density"];
  CHECK(left_out["blocks"] == 621);  // the body is still in the other nine
  CHECK(left_out["standard_error"].get<double>() > 0);
  CHECK(left_out["effective_parameters"].get<double>() > 7);
  CHECK(contains(read_text(folder / "r.html"), "\"log_density\""));

  CHECK(run_decid(command + " --threads 1").out == result.out);
}

TEST_CASE("fit: ranges and priors of parameters, a subject's body, and known values beside") {
  const Folder folder;
  run_ok("simulate" + with_brief_protocol(folder) + "--nv 0.3 --seed 4 -o " + folder / "t.csv");
  const std::string known =
      " --range delay=0.05,0.2 --prior delay=0.12,0.01 --prior Kp=850,20 --range Kp_pass=100,250 --moved-before "
      "--mass 88.86 --height 1.8 --truth Kp=850,Kd=250,Kp_pass=200,Kd_pass=100,Nv=0.3,theta=0.001,delay=0.1";
  const auto result = run_ok("fit --quiet --json" + with_brief_protocol(folder) + "--max-draws 8" + known + " " +
                             folder / "t.csv" + " --draws " + folder / "d.npz");
  const Json all = Json::parse(result.out), recording = all["recordings"].at(0);
  const decid::sim::ParameterTable& table = decid::sim::single_pendulum().parameters;
  for (std::size_t p = 0; p < table.size(); ++p) {
    const Json& parameter = recording["parameters"][p];
    const std::string name = parameter["name"];
    CAPTURE(name);
    const Json range = name == "delay" ? Json{0.05, 0.2} : name == "Kp_pass" ? Json{100.0, 250.0} : parameter["range"];
    const Json prior = name == "delay" ? Json{{"mean", 0.12}, {"sd", 0.01}}
                       : name == "Kp"  ? Json{{"mean", 850.0}, {"sd", 20.0}}
                                       : Json(nullptr);
    CHECK(parameter["range"] == range);
    if (name != "delay" && name != "Kp_pass") {  // the body is the default one but for its digits
      CHECK(near(range[0].get<double>(), table[p].low, 1e-5));
      CHECK(near(range[1].get<double>(), table[p].high, 1e-5));
    }
    CHECK(parameter.value("prior", Json(nullptr)) == prior);
    CHECK(parameter["interval90"][0].get<double>() >= range[0].get<double>());
    CHECK(parameter["interval90"][1].get<double>() <= range[1].get<double>());
  }
  const Json& kp = recording["parameters"][0];
  CHECK(kp["true"] == 850);
  CHECK(near(kp["value"].get<double>() / kp["normalized"].get<double>(), 838.98, 1e-3));  // m g h
  const std::vector<std::string> options = all["options"];
  for (const char* option : {"--range delay=0.05,0.2 Kp_pass=100,250", "--prior delay=0.12,0.01 Kp=850,20"})
    CHECK(std::ranges::count(options, option) == 1);
  CHECK(std::ranges::count_if(options, [](const std::string& o) { return o.starts_with("--moved-before"); }) == 1);
  CHECK(recording["slow_noise_deg"]["value"].get<double>() > 0.0);
  CHECK(recording["slow_noise_deg"]["memory_s"].get<double>() > 0.0);
  CHECK(recording["diagnostics"]["rhat"].size() == 10);
  CHECK(contains(read_text(folder / "d.npz"), "slow_noise_deg.npy"));
  const auto noise_deg = [&](const std::string& prior) {
    return first_recording("fit --quiet --json" + with_brief_protocol(folder) + "--max-draws 8 --prior-noise " + prior +
                           " " + folder / "t.csv")["sensor_noise_deg"]["value"]
        .get<double>();
  };
  CHECK(noise_deg("0.0001") < noise_deg("5"));
}

TEST_CASE("fit: priors over m g h are each body's own, and rerun repeats them") {
  const Folder folder;
  run_ok("simulate" + with_brief_protocol(folder) + "--nv 0.3 --seed 4 -o " + folder / "a.csv");
  std::filesystem::copy_file(folder / "a.csv", folder / "b.csv");
  write_text(folder / "s.csv", "participant_id,file,weight,height\nA,a.csv,60,1.6\nB,b.csv,90,1.8\n");
  const std::string call = "fit --quiet --max-draws 8" + with_brief_protocol(folder) + "--study " + folder / "s.csv",
                    saved = folder / "o.json";
  run_ok(call + " --prior Kp/mgh=1.0,0.2 --range Kd/mgh=0.1,0.6 --fix Kp_pass/mgh=0.2 -o " + saved);
  const Json all = read_json(saved);
  std::vector<double> of_bodies;
  for (const Json& recording : all["recordings"]) {
    const Json& kp = recording["parameters"][decid::sim::Kp];
    const double mgh = of_bodies.emplace_back(kp["value"].get<double>() / kp["normalized"].get<double>());
    CHECK(near(kp["prior"]["mean"].get<double>(), mgh, 1e-9));
    CHECK(near(kp["prior"]["sd"].get<double>(), 0.2 * mgh, 1e-9));
    const Json& kd = recording["parameters"][decid::sim::Kd];
    CHECK(near(kd["range"][0].get<double>(), 0.1 * mgh, 1e-9));
    CHECK(near(kd["range"][1].get<double>(), 0.6 * mgh, 1e-9));
    const Json& passive = recording["parameters"][decid::sim::Kp_pass];
    CHECK(near(passive["value"].get<double>(), 0.2 * mgh, 1e-9));
    CHECK(passive["fixed"] == true);
    for (const Json& warning : recording["warnings"]) CHECK(warning["code"] != "priors_of_all_bodies");
  }
  REQUIRE(of_bodies.size() == 2);
  CHECK(of_bodies[1] > 1.5 * of_bodies[0]);
  const std::vector<std::string> options = all["options"];
  CHECK(std::ranges::count(options, "--prior Kp/mgh=1.0,0.2") == 1);
  run_ok("rerun " + saved + " -o " + folder / "again.json");
  // In N m/rad of the first body, the same bits.
  const std::string of_first = "fit --quiet --max-draws 8 --mass 60 --height 1.6" + with_brief_protocol(folder) +
                               folder / "a.csv" +
                               " --prior Kp/mgh=1.0,0.2 --range Kd/mgh=0.1,0.6 --fix Kp_pass/mgh=0.2";
  CHECK(first_recording(of_first + " --json")["parameters"] == all["recordings"][0]["parameters"]);
  // A mean over m g h within a range in N m/rad is within it for the sheet's bodies, or not for some.
  const Result mixed = run_decid(call + " --range Kp=300,600 --prior Kp/mgh=1,0.05 --json");
  CHECK(mixed.code == 2);
  const Json of_mixed = Json::parse(mixed.out)["recordings"];
  CHECK(!of_mixed[0].contains("error"));
  CHECK(of_mixed[1].contains("error"));
  check_refused(
      "fit --quiet" + with_brief_protocol(folder) + folder / "a.csv" + " --range Kp=300,600 --prior Kp/mgh=1,0.05",
      "--prior");
}

TEST_CASE("fit: a person's body does not replace a robot's, which the protocol has") {
  const Folder folder;
  write_text(folder / "robot.json", R"({"body": {"mass_kg": 60, "com_height_m": 0.8, "inertia_kgm2": 42}})");
  write_text(folder / "log.csv", "time,sway_deg\n0,1\n");
  const std::string person = " --mass 60 --height 1.4 --protocol " + folder / "robot.json";
  check_refused("fit " + folder / "log.csv" + person, "--mass, --height: ");
  check_refused("design" + person, "--mass, --height: ");
  write_text(folder / "brief.json",
             std::string(R"({"body": {"mass_kg": 60, "com_height_m": 0.8, "inertia_kgm2": 42}, )") +
                 std::string(brief_protocol).substr(1));
  const std::string robot = " --quiet --protocol " + folder / "brief.json";
  run_ok("simulate --kp 500 --kd 130 --kp-pass 120 --kd-pass 60 --delay 0.06" + robot + " -o " + folder / "t.csv");
  run_ok("fit --max-draws 8 " + folder / "t.csv" + robot + " -o " + folder / "o.json");
  const Json kp = read_json(folder / "o.json")["recordings"][0]["parameters"][0];
  CHECK(near(kp["value"].get<double>() / kp["normalized"].get<double>(), 60.0 * 9.81 * 0.8, 1e-9));
}

TEST_CASE("fit: controllers are compared, parameters fixed; a journal of other controllers is refused") {
  const Folder folder;
  write_text(folder / "tiny.json", brief_protocol);
  const std::string protocol = " --protocol " + folder / "tiny.json";
  for (const char* seed : {"1", "2"})
    run_ok("simulate --quiet" + protocol + " --seed " + seed + " -o " + folder / seed + ".csv");
  const std::string fit =
      "fit --quiet --max-draws 8" + protocol + " " + folder / "1.csv" + " " + folder / "2.csv" + " ";
  const auto result = run_ok(fit + "--fix delay=0.12 --controller dec,ic -o " + folder / "o.json");
  const Json all = read_json(folder / "o.json"), sums = all["controller_comparison"];
  CHECK(contains(result.out, "Controllers over 2 recordings"));
  CHECK(result.out.find("Best controller over 2 recordings: ") < result.out.find("1.csv ("));
  CHECK(sums["recordings"] == 2);
  REQUIRE(sums["controllers"].size() == 2);
  CHECK(sums["controllers"][0]["best_in"].get<int>() + sums["controllers"][1]["best_in"].get<int>() == 2);
  CHECK(all["controller"] == "dec");
  for (const Json& recording : all["recordings"]) {
    const Json& controllers = recording["controllers"];
    REQUIRE(controllers.size() == 2);
    CHECK(controllers[1]["controller"] == "ic");
    CHECK(near(controllers[0]["weight"].get<double>() + controllers[1]["weight"].get<double>(), 1.0, 1e-9));
    CHECK(near(controllers[0]["log_predictive_density"].get<double>(),
               recording["log_predictive_density"]["value"].get<double>(), 1e-12));
    CHECK(controllers[1]["predictive_check"]["figures"].size() == 8);
    REQUIRE(controllers[1]["parameters"].size() == 6);
    for (const Json& parameters : {recording["parameters"], controllers[1]["parameters"]}) {
      const Json& delay = parameters.back();
      CHECK(delay["name"] == "delay");
      CHECK(near(delay["value"].get<double>(), 0.12, 1e-9));
      CHECK(delay["sd"].get<double>() < 1e-9);  // fixed for both
    }
    CHECK(recording["parameters"][6]["fixed"] == true);
  }

  // A missing recording leaves the others' results in the journal.
  const std::string some = fit + folder / "none.csv" + " -o " + folder / "j.json";
  CHECK(run_decid(some).code == 2);
  check_refused(some + " --resume --controller dec,ic", "j.json.journal");
  CHECK(run_decid(some + " --resume --controller dec").code == 2);
  CHECK_FALSE(read_json(folder / "j.json").contains("controller_comparison"));
}

// Guards that nothing drawn is lost.
TEST_CASE("fit: Ctrl-C keeps the draws" * doctest::test_suite("slow")) {
  const Folder folder;
  run_ok("simulate" + with_brief_protocol(folder) + "--seed 4 -o " + folder / "t.csv");
  std::string files;
  for (int i = 0; i < 100; ++i) files += " " + folder / "t.csv";
  // Ctrl-C after a line of progress in the middle of drawing. A terminal has one every 0.2 s, a file every 10 s.
  write_text(folder / "fit.sh", "echo $$ >" + folder / "pid" +
                                    "; exec " DECID_PROGRAM " fit --threads 1 --max-draws 40" +
                                    with_brief_protocol(folder) + files + " -o " + folder / "o.json" + " --report " +
                                    folder / "r.html" + " >" + folder / "out");
  const int status =
      std::system(("err=" + folder / "err" + "; script -qefc 'sh " + folder / "fit.sh" +
                   "' $err >/dev/null </dev/null & child=$!; " + "while kill -0 $child && ! { [ -s " +
                   folder / "o.json.journal" + " ] && grep -q \"drawing, R-hat\" $err; }; do sleep 0.02; " +
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
    CHECK(recording["diagnostics"]["draws"].get<int>() <= 320);
    whole += recording["diagnostics"]["draws"] == 320 ? 1 : 0;
  }
  CHECK(whole + std::thread::hardware_concurrency() >= recordings.size());
  CHECK(contains(read_text(folder / "r.html"), "</html>"));
}

TEST_CASE("fit: where chains disagree, the network's values have its intervals; sway of the other sign is not usable" *
          doctest::test_suite("slow")) {
  const Folder folder;
  run_ok("simulate --seed 7 --quiet -o " + folder / "t.csv");
  const auto first = [](const std::string& command) { return first_recording(command + " --json"); };
  const std::string golden = DECID_SOURCE_DIR "/tests/golden/0.2.0/";  // a network of trials of 4 s
  const std::string few = "fit --quiet --seed 2 --max-draws 8 ",
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
