// decid fit --joint: several recordings of one person fitted together, by a sheet or all of a call.
#include "tests/tools/decid/run.hpp"

using namespace decid::test;
using Json = nlohmann::json;

namespace {

/// Three recordings of a person with eyes open and closed, and one of another person.
struct People {
  Folder folder;
  std::string protocol;
  People() {
    write_text(folder / "tiny.json", brief_protocol);
    protocol = " --protocol " + folder / "tiny.json";
    for (const char* name : {"a1", "a2", "a3", "b1"})
      run_ok("simulate --quiet" + protocol + " --seed " + name[1] + " -o " + folder / name + ".csv");
  }
  std::string command(const std::string& options) const {
    return "fit --quiet --json --max-draws 8 --seed 3" + protocol + " " + options;
  }
};

const Json& parameter(const Json& json, std::size_t recording, std::size_t p) {
  return json["recordings"][recording]["parameters"][p];
}

}  // namespace

TEST_CASE_FIXTURE(People, "fit --joint: recordings of a person share parameters, but for those that are free") {
  write_text(folder / "people.csv", "participant_id,file,eyes\nA,a1.csv,open\na,a3.csv,closed\nB,b1.csv,open\n");
  const std::string options = "--study " + folder / "people.csv" + " --joint participant_id --free theta:eyes";
  const Json json = Json::parse(run_ok(command(options)).out);
  REQUIRE(json["recordings"].size() == 3);
  CHECK(parameter(json, 0, 0) == parameter(json, 1, 0));
  CHECK(parameter(json, 0, 5)["value"] != parameter(json, 1, 5)["value"]);
  const Json& joint = json["recordings"][1]["joint"];
  CHECK(joint["recordings"].size() == 2);
  CHECK(joint["free"] == Json::array({"theta"}));
  CHECK(joint["condition"] == "closed");
  CHECK_FALSE(json["recordings"][2].contains("joint"));  // the only recording of a person
}

TEST_CASE_FIXTURE(People, "fit --joint all: the recordings of a call, whose journal goes on with all of them") {
  const std::string files = folder / "a1.csv" + " " + folder / "a2.csv";
  const std::string call = command("--joint all " + files + " -o " + folder / "o.json");
  const Json json = Json::parse(run_ok(call).out);
  CHECK(parameter(json, 0, 6) == parameter(json, 1, 6));
  CHECK(json["recordings"][0]["joint"]["recordings"].size() == 2);
  CHECK_FALSE(json["recordings"][0]["joint"].contains("condition"));
  const std::string text = run_ok("fit --quiet --max-draws 8 --seed 3" + protocol + " --joint all " + files).out;
  CHECK(contains(text, "Fitted together: 2 recordings in 1 group\n"));
  // A missing recording leaves the others' results in the journal, but these depend on all: nothing is taken from it.
  const Result failed = run_decid(call + " " + folder / "none.csv");
  CHECK(failed.code != 0);
  CHECK(Json::parse(failed.out)["recordings"][1]["joint"]["recordings"].size() == 2);
  // The same recordings are not fitted again, as the journal does not grow, also with a file that cannot be read.
  const auto size = [&] { return std::filesystem::file_size(folder / "o.json.journal"); };
  const auto written = size();
  CHECK(run_decid(call + " " + folder / "none.csv" + " --resume").out == failed.out);
  CHECK(size() == written);
  write_text(folder / "odd.csv", "time,sway\n0,1\n0.01,x\n");
  const Result odd = run_decid(call + " " + folder / "odd.csv");
  CHECK(Json::parse(odd.out)["recordings"][2].contains("error"));
  const auto with_odd = size();
  CHECK(run_decid(call + " " + folder / "odd.csv" + " --resume").out == odd.out);
  CHECK(size() == with_odd);
  // A corrected one is fitted with the others.
  write_text(folder / "odd.csv", read_text(folder / "a3.csv"));
  const Json corrected = Json::parse(run_ok(call + " " + folder / "odd.csv" + " --resume").out);
  CHECK(corrected["recordings"][0]["joint"]["recordings"].size() == 3);
  CHECK(run_decid(call + " " + folder / "none.csv").code != 0);
  CHECK(Json::parse(run_ok(call + " --resume").out) == json);
}

TEST_CASE_FIXTURE(People, "fit --joint --group: recordings that are fitted together are one of the group's") {
  const std::string table = folder / "groups.csv";
  write_text(table, "file,group,subject\na1.csv,x,A\na2.csv,x,A\nb1.csv,y,B\n");
  const std::string files = folder / "a1.csv" + " " + folder / "a2.csv" + " " + folder / "b1.csv";
  write_text(folder / "three.csv", "subject,file\nA,a1.csv\nA,a2.csv\nB,b1.csv\n");
  const Json json = Json::parse(
      run_ok(command(files + " --study " + folder / "three.csv" + " --joint subject --group " + table)).out);
  CHECK(json["recordings"][1]["joint"]["recordings"].size() == 2);
  const Json& group = json["groups"][0];
  CHECK(group["participants"] == 1);
  CHECK(group["parameters"][0]["mean"] == parameter(json, 0, 0)["value"]);
}

TEST_CASE_FIXTURE(People, "calibrate --with: people recorded several times") {
  const std::string call = "calibrate --quiet --json --trials 1 --max-draws 8" + protocol;
  const Json one = Json::parse(run_ok(call).out),
             three =
                 Json::parse(run_ok(call + " --with " + folder / "tiny.json" + " --with " + folder / "tiny.json").out);
  CHECK(three["settings"]["with"].size() == 2);
  CHECK(one["trials"][0]["truth"] == three["trials"][0]["truth"]);
  CHECK(three["calibration"]["all"]["predicted_variance"] != one["calibration"]["all"]["predicted_variance"]);
  check_refused(call + " --faults --with short", "--with");
}
