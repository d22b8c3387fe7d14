// decid rerun of calls that print their JSON and write something else: a data set, a model, exported C.

#include <algorithm>

#include "base/files/sha256.hpp"
#include "tests/tools/decid/run.hpp"

using namespace decid::test;
using Json = nlohmann::json;

namespace {

/// Runs the call with --json, and then decid rerun of it. Returns the JSON, whose bytes both calls printed.
Json repeated(const Folder& folder, const std::string& call, const std::string& options) {
  const std::string first = folder / "first.json", again = folder / "again.json";
  write_text(first, run_ok(call + " " + options).out);
  const Json json = read_json(first);
  CHECK(json.at("command") == call);
  CHECK(json.at("decid") == DECID_VERSION);
  run_ok("rerun --quiet " + first + " -o " + again);
  CHECK(read_text(again) == read_text(first));
  return json;
}

bool hashes_name(const Json& json, const std::string& file) {
  return std::ranges::any_of(json.at("inputs"), [&](const Json& input) {
    return input.at("file") == file && input.at("sha256") == decid::sha256(read_text(file));
  });
}

}  // namespace

TEST_CASE("rerun: a data set, a training on it and its model") {
  const Folder folder;
  const std::string protocol = quick_protocol(folder), data = folder / "d.npz", model = folder / "m.safetensors";
  const Json made =
      repeated(folder, "dataset", "--json --quiet --count 40 --seed 7 --protocol " + protocol + " -o " + data);
  CHECK(made.at("arguments") == Json::array({"--count=40", "--seed=7", "--protocol=" + protocol}));
  CHECK(made.at("seed") == 7);
  CHECK(made.at("file") == data);
  CHECK(made.at("sha256") == decid::sha256(read_text(data)));
  CHECK(hashes_name(made, protocol));

  const std::string options =
      "--json --quiet --preset small --data " + data + " --report " + folder / "m.html" + " -o " + model + " --epochs ";
  const Json trained = repeated(folder, "train", options + "1");
  const std::string first = read_text(folder / "first.json");
  CHECK(trained.at("seed") == 1);
  CHECK(trained.at("model") == model);
  CHECK(hashes_name(trained, data));
  CHECK(page_data(folder / "m.html").at("call").at("inputs") == trained.at("inputs"));
  const Json about = repeated(folder, "info", "--json " + model);
  CHECK(about.at("weights_sha256") == trained.at("weights_sha256"));
  CHECK(hashes_name(about, model));
  repeated(folder, "info", "--controllers --json");

  // A training that went on to more epochs depends on more than its call; one that was stopped does not.
  write_text(folder / "more.json", run_ok("train --resume " + options + "2").out);
  CHECK(read_json(folder / "more.json").at("extensions").dump() == R"([{"after":1,"planned":1}])");
  check_refused("rerun " + folder / "more.json", "--resume");
  write_text(folder / "same.json", run_ok("train --resume " + options + "2").out);
  CHECK(read_text(folder / "same.json") == read_text(folder / "more.json"));

  // Other trials under the same name.
  write_text(folder / "t.json", first);
  run_ok("dataset --quiet --count 40 --seed 8 --protocol " + protocol + " -o " + data);
  check_refused("rerun " + folder / "t.json", "d.npz");
}

TEST_CASE("rerun: exported C, whose hashes the JSON has; a self-test is the machine's own") {
  const Folder folder;
  const std::string model = DECID_SOURCE_DIR "/models/firmware.safetensors", output = folder / "c";
  const auto check_files = [&](const Json& json) {
    for (std::size_t i = 0; i < 2; ++i) {
      const std::string file = output + "/" + json.at("files")[i].get<std::string>();
      CHECK(json.at("files_sha256")[i] == decid::sha256(read_text(file)));
    }
  };
  const Json exported = repeated(folder, "export c", model + " --name sway --json -o " + output);
  CHECK(exported.at("arguments") == Json::array({"--name=sway", model}));
  CHECK(hashes_name(exported, model));
  check_files(exported);

  run_ok("simulate --quiet --seed 5 -o " + folder / "t.csv");
  const std::string result = folder / "r.json";
  run_ok("identify --quiet --mass 70 --height 1.75 " + folder / "t.csv" + " -o " + result);
  const Json controller = repeated(folder, "export controller", "--force --kp 900 " + result + " --json -o " + output);
  CHECK(controller.at("arguments") == Json::array({"--kp=900", "--force", result}));
  CHECK(hashes_name(controller, result));
  check_files(controller);

  write_text(folder / "self.json", run_ok("selftest --json").out);
  CHECK(read_json(folder / "self.json").at("command") == "selftest");
  check_refused("rerun " + folder / "self.json", "selftest");
}
