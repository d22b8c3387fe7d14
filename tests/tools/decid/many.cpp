// Many recordings in one call of decid identify or decid fit: folders, tables, groups, and going on after a stop.

#include "tests/tools/decid/run.hpp"

using namespace decid::test;
using Json = nlohmann::json;

namespace {

void simulate(const std::string& file, const std::string& options) {
  run_ok("simulate --quiet " + options + " -o " + file);
}

/// The table says what the JSON says.
void check_table(const std::string& table, const Json& json) {
  const Cells rows = cells_of(table);
  REQUIRE(rows.size() == json["recordings"].size() + 1);
  for (std::size_t i = 0; i < json["recordings"].size(); ++i) {
    const Json& recording = json["recordings"][i];
    REQUIRE(rows[i + 1].size() == rows[0].size());
    CHECK(rows[i + 1][0] == recording["file"].get<std::string>());
    CHECK(rows[i + 1][1] == recording.value("trust", ""));
    CHECK(rows[i + 1].back().empty() != recording.contains("error"));
    for (std::size_t p = 0; p < 7; ++p) {
      if (recording.contains("error")) {
        CHECK(rows[i + 1][2 + 3 * p].empty());
        continue;
      }
      const Json& parameter = recording["parameters"][p];
      CHECK(rows[0][2 + 3 * p] == parameter["name"].get<std::string>());
      CHECK(std::stod(rows[i + 1][2 + 3 * p]) == parameter["value"]);
      CHECK(std::stod(rows[i + 1][3 + 3 * p]) == parameter["interval90"][0]);
      CHECK(std::stod(rows[i + 1][4 + 3 * p]) == parameter["interval90"][1]);
    }
  }
}

}  // namespace

TEST_CASE("identify: a folder, a quoted pattern, a table and groups") {
  const Folder folder;
  std::filesystem::create_directory(folder / "in");
  for (int i = 1; i <= 4; ++i)
    simulate(folder / "in/s" + std::to_string(i) + ".csv",
             "--seed " + std::to_string(i) + " --delay " + (i % 2 == 0 ? "0.1" : "0.2"));
  write_text(folder / "in/s5.csv", "time,sway\n0,1\n0.01,x\n");
  write_text(folder / "in/groups.csv",
             "file,group,subject\ns1.csv,slow,a\ns2.csv,fast,b\ns3.csv,slow,c\ns4.csv,fast,d\ns5.csv,fast,b\n");
  // Outputs in the folder, of a first call and of this one, are no recordings.
  const std::string command = "identify " + folder / "in" + " --json --table " + folder / "in/results.csv" +
                              " --group " + folder / "in/groups.csv" + " --report " + folder / "r.html";
  run_decid(command);
  const Result result = run_decid(command);
  CAPTURE(result.err);
  CHECK(result.code == 2);
  CHECK(contains(result.err, "1 of 5 recordings failed"));
  CHECK(result.err.find("identify: ") == result.err.rfind("identify: "));  // no progress of a few
  const Json json = Json::parse(result.out);
  REQUIRE(json["recordings"].size() == 5);
  CHECK(json["recordings"][4].contains("error"));
  check_table(read_text(folder / "in/results.csv"), json);
  CHECK(json["recordings"][1]["group"] == "fast");
  CHECK(json["groups"][0]["name"] == "fast");
  CHECK(json["groups"][0]["participants"] == 2);
  CHECK(json["groups"][0]["recordings"] == 2);
  CHECK(json["recordings"][4]["participant_id"] == "b");
  CHECK(json["group_comparison"]["left_out"][0]["reason"] == "error");
  const Json& delay = json["comparisons"][0]["parameters"][6];
  CHECK(delay["difference"].get<double>() < -0.05);
  CHECK(delay["hedges_g"].get<double>() < 0.0);
  CHECK(delay["adjusted_interval95"][1].get<double>() > delay["interval95"][1].get<double>());
  CHECK(contains(read_text(folder / "r.html"), "hedges_g"));

  const Result some = run_ok("identify --json '" + folder / "in/s[23].csv" + "'");
  REQUIRE(Json::parse(some.out)["recordings"].size() == 2);
  CHECK(Json::parse(some.out)["recordings"][1]["parameters"] == json["recordings"][2]["parameters"]);
  CHECK(contains(run_decid("identify " + folder / "in/s1.csv" + " " + folder / "in/s2.csv" + " --group " +
                           folder / "in/groups.csv")
                     .out,
                 "fast minus slow"));
}

namespace {

/// Two recordings below each other, the first column saying which; the second has `wrong` in its second row.
std::string long_table(const std::string& first, const std::string& second, const std::string& wrong) {
  std::string table;
  int trial = 0;
  for (const std::string& text : {first, second}) {
    std::istringstream lines(text);
    ++trial;
    int number = 0;
    for (std::string line; std::getline(lines, line); ++number) {
      if (number == 0 && trial == 1) table += "trial," + line + "\n";
      if (number == 0) continue;
      if (number == 2 && trial == 2 && !wrong.empty()) line.replace(0, line.find(','), wrong);
      table += std::to_string(trial) + "," + line + "\n";
    }
  }
  return table;
}

}  // namespace

TEST_CASE("identify: --trial makes the recordings of a file those of files of their own") {
  const Folder folder;
  for (int i = 1; i <= 2; ++i) simulate(folder / std::to_string(i) + ".csv", "--seed " + std::to_string(i));
  const std::string first = read_text(folder / "1.csv"), second = read_text(folder / "2.csv");
  write_text(folder / "long.csv", long_table(first, second, ""));
  const Result apart = run_decid("identify --json " + folder / "1.csv" + " " + folder / "2.csv");
  write_text(folder / "g.csv", "file,group\nlong.csv#1,a\nlong.csv#2,b\n");
  const Result result = run_ok("identify --json --trial trial --group " + folder / "g.csv" + " --table " +
                               folder / "t.csv" + " --report " + folder / "r.html" + " " + folder / "long.csv");
  const Json json = Json::parse(result.out), expected = Json::parse(apart.out);
  REQUIRE(json["recordings"].size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(json["recordings"][i]["file"] == folder / "long.csv" + "#" + std::to_string(i + 1));
    CHECK(json["recordings"][i]["parameters"] == expected["recordings"][i]["parameters"]);
  }
  CHECK(json["recordings"][1]["group"] == "b");
  check_table(read_text(folder / "t.csv"), json);
  check_refused("identify --quiet --trial trial --group " + folder / "g.csv" + " " + folder / "long.csv" + " " +
                    folder / "./long.csv",
                "long.csv#1: is the same recording as ");
  // One that cannot be used does not stop the other.
  write_text(folder / "long.csv", long_table(first, second, "x"));
  const Result wrong = run_decid("identify --json --trial trial " + folder / "long.csv");
  CHECK(wrong.code == 2);
  const Json kept = Json::parse(wrong.out);
  CHECK(kept["recordings"][0]["parameters"] == expected["recordings"][0]["parameters"]);
  CHECK(kept["recordings"][1].contains("error"));
  CHECK(contains(wrong.err, "long.csv#2"));
}

TEST_CASE("fit: going on after a stop makes the bytes of a call that was never stopped" * doctest::test_suite("slow")) {
  const Folder folder;
  std::filesystem::create_directory(folder / "in");
  write_text(folder / "tiny.json", brief_protocol);
  const std::string protocol = "--protocol " + folder / "tiny.json" + " ";
  for (int i = 1; i <= 3; ++i)
    simulate(folder / "in/s" + std::to_string(i) + ".csv", protocol + "--nv 0.3 --seed " + std::to_string(i));
  write_text(folder / "in/s0.csv", "time,sway\n0,1\n0.01,x\n");
  const auto outputs = [&](const std::string& name) {
    return " -o " + folder / name + ".json" + " --table " + folder / name + ".csv" + " --draws " + folder / name +
           ".npz" + " --report " + folder / name + ".html";
  };
  const std::string command = "fit " + protocol + "--max-draws 8 --quiet " + folder / "in";
  const Result whole = run_decid(command + outputs("whole"));
  CAPTURE(whole.err);
  CHECK(whole.code == 2);
  CHECK(contains(whole.err, "1 of 4 recordings failed"));
  const Json json = read_json(folder / "whole.json");
  REQUIRE(json["recordings"].size() == 4);
  CHECK(json["recordings"][0].contains("error"));
  check_table(read_text(folder / "whole.csv"), json);
  // The journal stays because one recording failed. A kill within the second recording:
  const std::string journal = read_text(folder / "whole.json.journal");
  write_text(folder / "again.json.journal", journal.substr(0, journal.size() / 2));
  const Result again = run_decid(command + " --resume --threads 1" + outputs("again"));
  CHECK(again.code == 2);
  for (const char* ending : {".json", ".csv", ".npz", ".html"}) {
    CAPTURE(ending);
    CHECK(read_text(folder / "again" + ending) == read_text(folder / "whole" + ending));
  }
  // Recordings in the journal are not fitted again: each fit prints the seconds that it took then.
  write_text(folder / "marked.json.journal", journal);
  std::filesystem::remove(folder / "in/s0.csv");
  const Result corrected = run_ok(command + " --resume" + outputs("marked"));
  REQUIRE(contains(corrected.out, "R-hat "));
  CHECK(whole.out.starts_with("4 recordings: "));
  CHECK(corrected.out.starts_with("3 recordings: "));
  CHECK(contains(whole.out, corrected.out.substr(corrected.out.find('\n') + 1)));
  CHECK(corrected.err.empty());
  CHECK_FALSE(std::filesystem::exists(folder / "marked.json.journal"));
  CHECK(read_json(folder / "marked.json")["recordings"].size() == 3);

  // Two of them in one file.
  write_text(folder / "long.csv", long_table(read_text(folder / "in/s1.csv"), read_text(folder / "in/s2.csv"), ""));
  const Result together = run_ok("fit " + protocol + "--max-draws 8 --quiet --json --trial trial " +
                                 folder / "long.csv" + " -o " + folder / "long.json");
  for (std::size_t i = 0; i < 2; ++i) {
    const Json recording = Json::parse(together.out)["recordings"][i];
    CHECK(recording["file"] == folder / "long.csv" + "#" + std::to_string(i + 1));
    CHECK(recording["parameters"] == json["recordings"][i + 1]["parameters"]);
  }

  // The journal of a call without --draws has no log likelihoods: --draws fits again, and is whole.
  const std::string with_missing = command + " " + folder / "none.csv";
  CHECK(run_decid(with_missing + " -o " + folder / "late.json").code == 2);
  run_decid(command + " --resume -o " + folder / "late.json" + " --draws " + folder / "late.npz");
  CHECK(read_text(folder / "late.npz") == read_text(folder / "marked.npz"));

  write_text(folder / "again.json.journal", journal);
  check_refused(command + " --resume --seed 7" + outputs("again"), "again.json.journal");
}
