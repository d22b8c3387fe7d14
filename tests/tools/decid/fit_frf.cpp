// decid fit --frf, as scripts call it.

#include "sim/body_model.hpp"
#include "tests/tools/decid/run.hpp"

using namespace decid::test;
using Json = nlohmann::json;

namespace {

const std::string example = std::string(DECID_SOURCE_DIR) + "/examples/frf.csv";

Json fitted(const std::string& options) {
  const auto result = run_ok("fit --frf " + options + " --json");
  return Json::parse(result.out);
}

}  // namespace

TEST_CASE("fit --frf gives fit's keys, and the information of the table") {
  const Folder folder;
  const std::string command =
      "fit --frf " + example + " --protocol short --json -o " + folder / "o.json" + " --draws " + folder / "d.npz";
  const auto result = run_ok(command);
  CHECK(result.out == read_text(folder / "o.json"));
  const Json json = Json::parse(result.out);
  const decid::sim::ParameterTable& table = decid::sim::single_pendulum().parameters;
  REQUIRE(json["parameters"].size() == table.size());
  for (std::size_t p = 0; p < table.size(); ++p) {
    const Json& parameter = json["parameters"][p];
    CHECK(parameter["name"] == table[p].name);
    CHECK(parameter["sd"].get<double>() > 0.0);
    CHECK(parameter["prior_sd"].get<double>() > 0.0);
    CHECK(parameter["contraction"].get<double>() >= 0.0);
    CHECK(parameter["normalized_interval90"].is_null() != table[p].scales_with_mgh);
    CHECK(parameter["interval90"][0].get<double>() >= table[p].low);
    CHECK(parameter["interval90"][1].get<double>() <= table[p].high);
    CHECK(json["diagnostics"]["rhat"][table[p].name].get<double>() < 1.02);
    CHECK(near(json["correlations"][p][p].get<double>(), 1.0, 1e-12));
  }
  CHECK(json["diagnostics"]["agreed"] == true);
  CHECK(json["confidence"] == "sd");
  CHECK(json["misfit"]["degrees_of_freedom"] == 22);
  CHECK(json["misfit"]["p_value"].get<double>() > 0.01);
  CHECK(json["warnings"].empty());
  CHECK(json["fit"]["answer"] == "posterior");
  for (const char* key : {"frequency_hz", "gain", "phase_deg", "sd", "model_gain", "model_gain_interval90",
                          "model_phase_deg", "model_phase_interval90", "distance"})
    CHECK(json["frf"][key].size() == 11);
  for (std::size_t i = 0; i < 11; ++i) {
    const Json& frf = json["frf"];
    CHECK(frf["model_phase_interval90"][i][0].get<double>() < frf["model_phase_deg"][i].get<double>());
    CHECK(frf["model_phase_interval90"][i][1].get<double>() > frf["model_phase_deg"][i].get<double>());
    CHECK(std::abs(frf["model_phase_deg"][i].get<double>() - frf["phase_deg"][i].get<double>()) < 30.0);
  }
  for (const char* array : {"parameters.npy", "gain.npy", "error.npy", "chain.npy"})
    CHECK(contains(read_text(folder / "d.npz"), array));

  CHECK(json["command"] == "fit");
  CHECK(json["seed"] == 1);
  CHECK(json["inputs"][0]["file"] == example);
  const auto again = run_ok("rerun --threads 1 " + folder / "o.json" + " -o " + folder / "again.json");
  CHECK(contains(again.err, "computing times"));
  Json other = read_json(folder / "again.json"), first = json;
  for (Json* each : {&first, &other}) (*each)["fit"].erase("seconds");
  CHECK(first == other);
}

TEST_CASE("fit --frf takes the body, the tilt's size and known parameters") {
  const std::string usual = example + " --protocol short";
  const Json first = fitted(usual);
  const auto value = [](const Json& json, std::size_t p) { return json["parameters"][p]["value"].get<double>(); };
  const Json light = fitted(usual + " --mass 60 --height 1.6");
  CHECK(value(light, decid::sim::Kp) < value(first, decid::sim::Kp));
  // A smaller tilt passes less, unless the noise is larger or the threshold smaller.
  const Json small = fitted(usual + " --amplitude 0.5");
  CHECK(value(small, decid::sim::Theta) < value(first, decid::sim::Theta));
  const Json sure = fitted(usual + " --prior-gain 0 --prior-error 0");
  CHECK(sure["gain"]["sd"] == 0.0);
  CHECK(sure["error"]["sd"] == 0.0);
  const auto text =
      run_decid("fit --frf " + usual + " --truth Kp=900,Kd=260,Kp_pass=150,Kd_pass=120,Nv=.2,theta=.002,delay=.12");
  CHECK(text.code == 0);
  for (const char* words :
       {"11 frequencies, 0.05 to 2.2 Hz", "usable: table passed all checks", "contraction", "R-hat"})
    CHECK(contains(text.out, words));
  CHECK(text.out.find("chi-square") > text.out.find("contraction"));  // the answer comes first
  CHECK(contains(text.out, "posterior predictive p"));
}

TEST_CASE("fit --frf takes priors, ranges and known values of parameters") {
  const std::string usual = example + " --protocol short";
  const Json json = fitted(usual + " --fix Kd=260 --prior Kp=900,20 --range delay=0.1,0.2");
  const Json &kp = json["parameters"][decid::sim::Kp], &kd = json["parameters"][decid::sim::Kd];
  CHECK(kd["value"] == 260.0);
  CHECK(kd["sd"] == 0.0);
  CHECK(kd["fixed"] == true);
  CHECK(kp["prior"]["mean"] == 900.0);
  CHECK(kp["sd"].get<double>() < 20.0);
  CHECK(near(kp["prior_sd"].get<double>(), 20.0, 0.1));
  CHECK(json["parameters"][decid::sim::Delay]["range"] == Json::array({0.1, 0.2}));
  CHECK_FALSE(kp.contains("fixed"));
  CHECK(json["controller"] == "dec");
  CHECK(json["misfit"]["relative_error"].get<double>() < 0.1);
  CHECK_FALSE(json.contains("controllers"));
}

TEST_CASE("fit --frf takes priors over m g h of the body") {
  const std::string usual = example + " --protocol short --mass 60 --height 1.6";
  const Json json = fitted(usual + " --fix Kd/mgh=0.3 --prior Kp/mgh=1.1,0.02 --range Kp_pass/mgh=0.1,0.4");
  const Json &kp = json["parameters"][decid::sim::Kp], &kd = json["parameters"][decid::sim::Kd];
  const double mgh = kp["value"].get<double>() / kp["normalized"].get<double>();
  CHECK(mgh < 600.0);  // of 60 kg
  CHECK(near(kd["value"].get<double>(), 0.3 * mgh, 1e-9));
  CHECK(kd["fixed"] == true);
  CHECK(near(kp["prior"]["mean"].get<double>(), 1.1 * mgh, 1e-9));
  CHECK(near(kp["prior"]["sd"].get<double>(), 0.02 * mgh, 1e-9));
  CHECK(near(json["parameters"][decid::sim::Kp_pass]["range"][1].get<double>(), 0.4 * mgh, 1e-9));
}

// Three fits, and their cross-validation.
TEST_CASE("fit --frf compares controllers" * doctest::test_suite("slow")) {
  const Folder folder;
  const std::string page = folder / "p.html";
  const auto result =
      run_ok("fit --frf " + example + " --protocol short --controller dec,ic,dec2015 --fix G_q=0.13 -o " +
             folder / "o.json" + " --report " + page);
  CHECK(contains(result.out, "log predictive density"));
  const Json json = Json::parse(read_text(folder / "o.json"));
  CHECK(json["controller"] == "dec");
  REQUIRE(json["controllers"].size() == 3);
  double weights = 0.0, best = -1.0;
  for (const Json& each : json["controllers"]) {
    weights += each["weight"].get<double>();
    best = std::max(best, each["difference"].get<double>());
    CHECK(each["difference_standard_error"].get<double>() >= 0.0);
    CHECK(each["relative_error"].get<double>() > 0.0);
  }
  CHECK(near(weights, 1.0, 1e-9));
  CHECK(best == 0.0);
  CHECK_FALSE(json["controllers"][0].contains("parameters"));
  CHECK(json["controllers"][1]["controller"] == "ic");
  CHECK(json["controllers"][1]["parameters"].size() == 6);
  CHECK(near(json["controllers"][2]["parameters"][10]["value"].get<double>(), 0.13, 1e-9));
  CHECK(contains(read_text(page), "\"controllers\""));
  CHECK_FALSE(contains(read_text(page), "\"seconds\""));
}

TEST_CASE("fit --frf --objective log-ratio is the field's least squares") {
  const auto value = [](const Json& json, std::size_t p) { return json["parameters"][p]["value"].get<double>(); };
  const Json json = fitted(example + " --protocol short --objective log-ratio");
  CHECK(json["fit"]["answer"] == "log-ratio");
  CHECK(json["misfit"]["relative_error"].get<double>() < 0.1);
  CHECK(json["passing_gain"].get<double>() > 0.0);
  CHECK(json["parameters"][decid::sim::Kp]["at_end"] == false);
  CHECK_FALSE(json["parameters"][decid::sim::Kp].contains("sd"));
  CHECK(near(value(json, decid::sim::Delay), 0.12, 0.15));  // of the controller behind the example
  CHECK(json["frf"]["model_gain"].size() == 11);
  for (const std::string option : {"--prior-error 0.1", "--prior-gain 0.1"}) {
    const Result refused = run_decid("fit --frf " + example + " --objective log-ratio " + option);
    CHECK(refused.code == 2);
    CHECK(contains(refused.err, "has no effect"));
  }
}

TEST_CASE("fit --frf warns of a table that the model does not explain") {
  const Folder folder;
  write_text(folder / "t.csv",
             "frequency_hz,gain,phase_deg,sd\n0.05,4,90,0.1\n0.3,0.2,-60,0.01\n1.1,3,100,0.1\n2.2,1,-150,0.1\n");
  const auto text = run_ok("fit --frf " + folder / "t.csv" + " --protocol short");
  CHECK(contains(text.out, "no controller of this model explains the table"));
  CHECK_FALSE(contains(text.out, "Kp_pass"));  // no parameters that look like an answer
  write_text(folder / "u.csv", "frequency_hz,gain,phase_deg\n0.05,4,90\n0.3,0.2,-60\n1.1,3,100\n2.2,1,-150\n");
  const Json json = fitted(folder / "u.csv" + " --protocol short");
  CHECK(json["confidence"].is_null());
  CHECK(json["misfit"]["p_value"].is_null());
  CHECK(json["frf"]["sd"][0].is_null());
  REQUIRE(json["warnings"].size() == 2);
  CHECK(json["trust"] == "not usable");
  CHECK(json["warnings"][0]["code"] == "no_controller");
  CHECK(json["warnings"][1]["code"] == "response_unexplained");
}
