// --controller: the commands with each controller's own parameters, and what contradicts a protocol, a model or a
// result.

#include "sim/protocol/protocol_json.hpp"
#include "tests/tools/decid/run.hpp"

namespace decid {
namespace {

using namespace test;
using Json = nlohmann::json;

/// A data set of a controller and a model trained on it.
struct Trained {
  Folder folder;
  std::string protocol = quick_protocol(folder), data = folder / "d.npz", model = folder / "m.safetensors",
              trial = folder / "t.csv";

  explicit Trained(const std::string& controller) {
    const std::string with = " --protocol " + protocol + " --controller " + controller;
    run_ok("dataset --quiet --count 60 --base 50 --seed 5" + with + " -o " + data);
    run_ok("train --quiet --preset small --epochs 2 --data " + data + " -o " + model);
    run_ok("simulate --quiet --seed 3" + with + " -o " + trial);
  }
};

std::vector<std::string> names_of(const Json& parameters) {
  std::vector<std::string> names;
  for (const Json& parameter : parameters) names.push_back(parameter.at("name"));
  return names;
}

}  // namespace

TEST_CASE("controllers: data set, training, identification, study and export of each") {
  for (const sim::BodyModel* model : {&sim::dec2015(), &sim::independent_channels()}) {
    CAPTURE(model->name);
    const Trained of(model->name);
    const Json data = run_json("info --json " + of.model);
    CHECK(data["protocol"]["controller"] == model->name);
    CHECK(data["head"] == "point");
    const std::string result = of.folder / "r.json";
    run_ok("identify --quiet --controller " + model->name + " --model " + of.model + " -o " + result + " " + of.trial);
    const Json json = read_json(result);
    CHECK(json["protocol"]["controller"] == model->name);
    CHECK(names_of(json["recordings"][0]["parameters"]) == model->parameters.names());

    // A stream of the same controller trains the same network's shape.
    run_ok(
        "train --quiet --stream --stream-trials 64 --validation-trials 16 --preset small --head 'mixture 1' --epochs 1 "
        "--controller " +
        model->name + " --protocol " + of.protocol + " -o " + of.folder / "s.safetensors");
    CHECK(run_json("info --json " + of.folder / "s.safetensors")["protocol"]["controller"] == model->name);

    const Json study = Json::parse(run_ok("study --json --quiet --model " + of.model + " --data " + of.data +
                                          " --trials 40 --sensor-noise 0 -o " + of.folder / "study")
                                       .out);
    CHECK(study["errors"]["fresh"]["mse_per_parameter"].size() == model->parameters.size());
    CHECK(study["double_pendulum"].is_null());
    CHECK(study["mse_by_paper_sd"]["fresh"].is_null());
    CHECK(study["paper"]["mean"].empty());
    const Json compared = Json::parse(
        run_ok("evaluate --json --quiet --split all --data " + of.data + " --model " + of.folder / "s.safetensors")
            .out);
    CHECK(compared["mse_per_parameter"].size() == model->parameters.size());

    run_ok("export controller --quiet --force --name c " + result + " -o " + of.folder / "c");
    CHECK(contains(read_text(of.folder / "c/c.c"), "The " + model->name + " posture controller"));
    check_refused("export controller --controller dec --force " + result + " -o " + of.folder / "n", "r.json");
  }
}

TEST_CASE("controllers: simulate has the simulator's trial, by each controller's options") {
  const Folder folder;
  const std::string protocol = quick_protocol(folder), lab = folder / "lab.json";
  const auto simulated = [&](const std::string& options) {
    run_ok("simulate --quiet --seed 4 " + options + " -o " + folder / "t.csv");
    return read_text(folder / "t.csv");
  };
  Json with = read_json(protocol);
  with["controller"] = "dec2015";
  write_text(lab, with.dump());
  const std::string named = simulated("--controller dec2015 --gravity-gain 0.55 --protocol " + protocol);
  CHECK(named == simulated("--gravity-gain 0.55 --protocol " + lab));
  CHECK(named == simulated("--controller dec2015 --gravity-gain 0.55 --protocol " + lab));
  CHECK(named != simulated("--controller dec2015 --gravity-gain 0.6 --protocol " + protocol));
  CHECK(simulated("--controller dec --protocol " + protocol) == simulated("--protocol " + protocol));
  CHECK(simulated("--controller ic --weight 0.5 --protocol " + protocol) !=
        simulated("--controller ic --weight 0.6 --protocol " + protocol));
  for (const char* option : {"--tilt-gain", "--slow-gain"})
    CHECK(simulated("--controller dec2015 " + (option + (" 0.1 --protocol " + protocol))) !=
          simulated("--controller dec2015 " + (option + (" 0.2 --protocol " + protocol))));
  with["gravity_dead_band_deg"] = 0.07;
  write_text(folder / "band.json", with.dump());
  CHECK(named != simulated("--gravity-gain 0.55 --protocol " + folder / "band.json"));
}

TEST_CASE("controllers: info lists each with its parameters, ranges and sources") {
  const Json whole = Json::parse(run_ok("info --controllers --json").out), list = whole["controllers"];
  CHECK(whole["mgh"] == sim::Body{}.mgh());
  REQUIRE(list.size() == 3);
  const std::string text = run_ok("info --controllers").out;
  CHECK(contains(text, "m g h 839 N m/rad"));
  for (std::size_t i = 0; i < list.size(); ++i) {
    const sim::BodyModel& model = *sim::body_models()[i];
    CHECK(list[i]["name"] == model.name);
    CHECK(!list[i]["source"].get<std::string>().empty());
    REQUIRE(list[i]["parameters"].size() == model.parameters.size());
    for (std::size_t p = 0; p < model.parameters.size(); ++p) {
      CHECK(list[i]["parameters"][p]["low"] == model.parameters[p].low);
      CHECK(contains(text, " --" + model.parameters[p].option + " "));
    }
  }
}

}  // namespace decid
