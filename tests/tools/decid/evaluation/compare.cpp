// decid compare, as scripts call it.
#include <algorithm>

#include "sim/body_model.hpp"
#include "tests/tools/decid/run.hpp"
#include "tools/report/comparison_page.hpp"

using namespace decid::test;
using Json = nlohmann::json;

namespace {

constexpr const char* small = " --starts 1 --simulations 6500 --max-draws 8 --seed 3";

}  // namespace

TEST_CASE("compare: the table, the JSON and the page say the same" * doctest::test_suite("slow")) {
  const Folder folder;
  const std::string protocol = with_brief_protocol(folder), model = " --model " + folder / "m.safetensors" + " ";
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
  CHECK(contains(run_ok("rerun --threads 1 " + folder / "c.json").err, "computing times"));
  auto wrong = nlohmann::ordered_json::parse(result.out);  // rerun also compares the order
  wrong["methods"][0]["mse"] = 0.5;
  write_text(folder / "wrong.json", wrong.dump());
  CHECK(run_decid("rerun " + folder / "wrong.json").code == 1);
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
  // On trials of a data set, which have their own noise; in words.
  run_ok("dataset" + protocol + "--quiet --count 2 --seed 77 -o " + folder / "d.npz");
  run_ok("compare" + model + "--trials 1 --quiet --data " + folder / "d.npz" + small);
  CHECK(contains(read_text(folder / "c.html"), "fit from network"));
}

TEST_CASE("compare: another controller, its parameters, network and iterative fit" * doctest::test_suite("slow")) {
  const Folder folder;
  const std::string protocol = with_brief_protocol(folder);
  write_text(folder / "net.txt", "globalavgpool\nfc 6\n");
  run_ok("train --controller ic --stream --stream-trials 40 --validation-trials 20 --epochs 1 --head point --quiet" +
         (" --architecture " + folder / "net.txt") + protocol + "-o " + folder / "ic.safetensors");
  const std::string call = "compare --model " + folder / "ic.safetensors" + " --trials 1 --quiet --json" + small;
  const Json json = Json::parse(run_ok(call).out);
  REQUIRE(json["methods"].size() == 6);
  const decid::sim::ParameterTable& table = decid::sim::independent_channels().parameters;
  for (const Json& method : json["methods"]) {
    const Json& errors = method["mse_per_parameter"];
    REQUIRE(errors.size() == table.size());
    for (const decid::sim::ParameterInfo& info : table) CHECK(errors.contains(info.name));
  }
  check_refused(call + " --controller dec", "ic");
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
