// decid fit and decid compare, as scripts call them.
#include <doctest/doctest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "sim/body_model.hpp"
#include "tests/near.hpp"
#include "tests/tools/decid/run.hpp"
#include "tools/report/comparison_page.hpp"

using decid::test::check_refused;
using decid::test::Folder;
using decid::test::near;
using decid::test::read_text;
using decid::test::run_decid;
using decid::test::write_text;
using Json = nlohmann::json;

namespace {

constexpr const char* small = " --starts 1 --simulations 6500 --seed 3";

}  // namespace

TEST_CASE("fit says what identify says, and what the fit cost" * doctest::test_suite("slow")) {
  const Folder folder;
  REQUIRE(run_decid("simulate --nv 0.3 --seed 4 -o " + folder / "t.csv").code == 0);
  const auto result = run_decid("fit " + folder / "t.csv" + " --json -o " + folder / "o.json" + small);
  CAPTURE(result.err);
  REQUIRE(result.code == 0);
  CHECK(result.out == read_text(folder / "o.json"));
  const Json recording = Json::parse(result.out)["recordings"].at(0);
  REQUIRE(recording["parameters"].size() == decid::sim::single_pendulum().parameters.size());
  for (std::size_t p = 0; p < decid::sim::single_pendulum().parameters.size(); ++p) {
    const Json& parameter = recording["parameters"][p];
    const decid::sim::ParameterInfo& info = decid::sim::single_pendulum().parameters[p];
    CHECK(parameter["name"] == info.name);
    CHECK(parameter["unit"] == info.unit);
    CHECK(parameter["value"].get<double>() >= info.low);
    CHECK(parameter["value"].get<double>() <= info.high);
    CHECK(parameter["standard_error"].get<double>() > 0);
    // No distribution within a range is wider than half of it.
    CHECK(parameter["standard_error"].get<double>() <= 0.5 * (info.high - info.low));
    CHECK(parameter["normalized"].is_null() != info.per_mgh);
  }
  CHECK(recording["fit"]["simulations"].get<long long>() <= 6500);
  CHECK(recording["fit"]["seconds"].get<double>() > 0);
  CHECK(recording["fit"]["start"] == "network");
  CHECK(recording["fit"]["variance_accounted_for"].get<double>() > 0);

  Json other = Json::parse(run_decid("fit " + folder / "t.csv" + " --threads 1 --json" + small).out);
  Json first = Json::parse(result.out);
  for (Json* json : {&first, &other}) (*json)["recordings"][0]["fit"].erase("seconds");
  CHECK(first == other);
}

TEST_CASE("fit refuses what it cannot use, in one line") {
  const Folder folder;
  REQUIRE(run_decid("simulate --seed 4 -o " + folder / "t.csv").code == 0);
  write_text(folder / "short.csv", "time,com_sway_deg\n0,0\n0.01,0.1\n0.02,0.2\n");
  check_refused("fit " + folder / "t.csv" + " --start there", {"there", "middle"});
  check_refused("fit " + folder / "t.csv" + " --simulations 100", {"100 simulations", "allow"});
  check_refused("fit " + folder / "t.csv" + " --starts 0", {"--starts"});
  check_refused("fit " + folder / "t.csv" + " --rate 200", {"60.5 s", "121 s"});
  check_refused("fit " + folder / "t.csv" + " --protocol short", {"--start network"});
  REQUIRE(run_decid("simulate --protocol short --seed 4 -o " + folder / "s.csv").code == 0);
  check_refused("fit " + folder / "s.csv", {"63.7 s", "121 s"});
  check_refused("fit " + folder / "short.csv", {"short.csv"});
  check_refused("fit " + folder / "none.csv", {"none.csv"});
  check_refused("fit " + folder / "t.csv" + " --begin 2", {"119 s of them"});
  check_refused("fit " + folder / "t.csv" + " --begin 1 --tilt-column 3", {"--begin", "--tilt-column"});
  write_text(folder / "noise.mat", "no MAT-file");
  check_refused("fit " + folder / "noise.mat", {"noise.mat"});
  check_refused("fit " + folder / "t.csv" + " -o " + folder / "t.csv", {"another name"});
  check_refused("compare --data " + folder / "none.npz", {"none.npz"});
  check_refused("compare --trials 0", {"--trials"});
}

TEST_CASE("fit: one bad recording of several does not stop the others, and quiet leaves the figures") {
  const Folder folder;
  REQUIRE(run_decid("simulate --seed 4 -o " + folder / "t.csv").code == 0);
  write_text(folder / "bad.csv", "time,sway\n0,1\n0.01,x\n");
  const std::string command = "fit --quiet " + folder / "bad.csv" + " " + folder / "t.csv" + " -o " + folder / "o.json";
  const auto result = run_decid(command + small);
  CAPTURE(result.err);
  CHECK(result.code == 2);
  CHECK(result.err.find("bad.csv") != std::string::npos);
  CHECK(result.err.find("1 of 2 recordings failed") != std::string::npos);
  CHECK(result.out.find("bad.csv: not fitted") != std::string::npos);
  CHECK(result.out.find("Kp_pass") != std::string::npos);
  const Json json = Json::parse(read_text(folder / "o.json"));
  CHECK(json["recordings"][0].contains("error"));
  CHECK(json["recordings"][1]["fit"]["simulations"].get<long long>() > 0);
}

TEST_CASE("fit: a protocol that no model knows, from the middle; known parameters stand beside") {
  const Folder folder;
  const std::string truth = "Kp=850,Kd=250,Kp_pass=200,Kd_pass=100,Nv=0.3,theta=0.001,delay=0.1";
  REQUIRE(run_decid("simulate --protocol short --seed 4 -o " + folder / "t.csv").code == 0);
  const auto result =
      run_decid("fit " + folder / "t.csv" + " --json --protocol short --start middle --truth " + truth + small);
  CAPTURE(result.err);
  REQUIRE(result.code == 0);
  const Json recording = Json::parse(result.out)["recordings"][0];
  CHECK(recording["fit"]["start"] == "middle");
  CHECK(recording["parameters"][0]["true"] == 850);
}

TEST_CASE("compare: the table, the JSON and the page say the same" * doctest::test_suite("slow")) {
  const Folder folder;
  const auto result = run_decid("compare --trials 2 --sensor-noise 0.02 --quiet --json --report " + folder / "c.html" +
                                " -o " + folder / "c.json" + small);
  CAPTURE(result.err);
  REQUIRE(result.code == 0);
  const Json json = Json::parse(result.out);
  CHECK(json["trials"] == 2);
  REQUIRE(json["methods"].size() == 5);
  CHECK(json["methods"][0]["name"] == "network");
  CHECK(json["methods"][0]["simulations"] == 0);
  for (const Json& method : json["methods"]) {
    double sum = 0;
    for (const auto& [name, mse] : method["mse_per_parameter"].items()) sum += mse.get<double>();
    CHECK(near(method["mse"].get<double>(), sum / 7, 2e-15));  // another order of 7 numbers
    CHECK(method["simulations"].get<double>() <= 6500);
    CHECK(method["seconds"].get<double>() > 0);
    const std::string name = method["name"];
    CHECK(method["error_per_standard_error"].is_number() == (name == "fit" || name == "fit from network"));
  }
  CHECK(result.out == read_text(folder / "c.json"));
  // A study of the same model shows it, of another not.
  const std::string study = "study --quiet --trials 20 --realisations 1 --sensor-noise 0 -o " + folder / "study";
  const auto studied = run_decid(study + " --comparison " + folder / "c.json");
  CAPTURE(studied.err);
  REQUIRE(studied.code == 0);
  CHECK(studied.out.find("| fit from network |") != std::string::npos);
  const Json study_json = Json::parse(read_text(folder / "study/study.json"));
  CHECK(study_json["comparisons"] == Json::array({json}));
  CHECK(read_text(folder / "study/report.html").find("fit from network") != std::string::npos);
  Json other = json;
  other["weights_sha256"] = "0";
  write_text(folder / "other.json", other.dump());
  check_refused(study + " --comparison " + folder / "other.json", {"other.json", "another model"});
  other.erase("methods");
  write_text(folder / "other.json", other.dump());
  check_refused(study + " --comparison " + folder / "other.json", {"other.json", "not a comparison"});
  write_text(folder / "other.json", "{");
  check_refused(study + " --comparison " + folder / "other.json", {"other.json", "not valid JSON"});
  // Whoever looks at the page needs nothing else.
  const std::string page = read_text(folder / "c.html");
  CHECK(page.find("fit from network") != std::string::npos);
  CHECK(page.find("src=") == std::string::npos);
}

TEST_CASE("errors are squared differences over the deviation, averaged") {
  using namespace decid;
  const std::vector<sim::Parameters> truth(2, sim::Parameters(7));
  std::vector<sim::Parameters> estimates = truth;
  const sim::Parameters deviation{2, 2, 2, 2, 2, 2, 2};
  estimates[0][1] = 4;   // 2 deviations
  estimates[1][1] = -2;  // 1
  const MethodFigures figures = errors_of("a", "b", estimates, truth, deviation);
  CHECK(figures.mse_per_parameter[1] == 2.5);
  CHECK(figures.mse_per_parameter[0] == 0);
  CHECK(near(figures.mse, 2.5 / 7, 1e-15));
  // Of the two trials' 4/7 and 1/7: half their difference.
  CHECK(near(figures.mse_standard_error, 1.5 / 7, 2e-15));
}
