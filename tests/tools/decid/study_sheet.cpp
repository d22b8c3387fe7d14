// A study in one call: decid identify and fit with --study, their tables, draws, and decid rerun.

#include <cmath>

#include "recording/formats/xlsx.hpp"
#include "tests/tools/decid/run.hpp"

using namespace decid::test;
using Json = nlohmann::json;

namespace {

void simulate(const std::string& file, const std::string& options) {
  std::filesystem::create_directories(std::filesystem::path(file).parent_path());
  run_ok("simulate --quiet " + options + " -o '" + file + "'");
}

/// The keys that a call of its own does not have.
Json without_study(Json recording) {
  for (const char* key : {"participant_id", "session", "group", "condition", "columns", "protocol", "body"})
    recording.erase(key);
  return recording;
}

/// Identifies recordings of people in one call and in calls of their own, which must give the same bits.
void check_study_of(int people) {
  const Folder folder;
  std::string sheet = "participant_id\tfile\theight\tweight\tage\n";
  std::vector<std::string> calls;
  for (int i = 0; i < people; ++i) {
    const std::string name = "data/p" + std::to_string(i) + ".csv", height = std::to_string(160 + i),
                      mass = std::to_string(55 + i);
    simulate(folder / name, "--seed " + std::to_string(i));
    sheet += "P" + std::to_string(i) + "\t" + name + "\t" + height + "\t" + mass + "\t" + std::to_string(20 + i) + "\n";
    calls.push_back("identify --quiet --json " + folder / name + " --mass " + mass + " --height " + "1." +
                    height.substr(1));
  }
  write_text(folder / "participants.tsv", sheet);
  const Json study = run_json("identify --quiet --json --study " + folder / "participants.tsv");
  REQUIRE(study["recordings"].size() == calls.size());
  for (std::size_t i = 0; i < calls.size(); ++i) {
    const Json single = run_json(calls[i]);
    CHECK(without_study(study["recordings"][i]) == single["recordings"][0]);
    CHECK(study["recordings"][i]["body"] == single["body"]);
    CHECK(study["recordings"][i]["columns"]["age"] == std::to_string(20 + i));
  }
}

constexpr const char* feet = "\u00FC";         // of the sheet, NFC
constexpr const char* decomposed = "u\u0308";  // of the files, NFD

}  // namespace

// Guards the bits of a study: bodies share a call, so an identifier of another body must not be used.
TEST_CASE("a study of six bodies in one call gives what six calls give, to the bit") {
  check_study_of(6);
}

TEST_CASE("a study of 24 bodies in one call gives what 24 calls give, to the bit" * doctest::test_suite("slow")) {
  check_study_of(24);
}

TEST_CASE("a study as laboratories have it: umlauts, a missing trial, a wrong cell, its tables") {
  const Folder folder;
  const std::string name = std::string("M") + decomposed + "ller";
  simulate(folder / ("Gruppe A/" + name + "/" + name + "_offen.CSV"), "--seed 1");
  simulate(folder / ("Gruppe A/" + name + "/" + name + "_zu.csv"), "--seed 2");
  simulate(folder / "Gruppe B/K1.csv", "--seed 3");
  simulate(folder / "Gruppe B/K2.csv", "--seed 4");
  const std::string who = std::string("M") + feet + "ller";
  write_text(folder / "studie.csv",
             "Participant ID;File;Group;Condition;Height;Weight;Invert;Hand\n" + who + ";gruppe a\\" + who + "\\" +
                 who + "_offen;patients;open;1,75;70;;right\n" + who + ";" + who +
                 "_zu.csv;patients;closed;175;70;;right\n" + "K1;K1.csv;controls;open;168;61,5;sway;=left\n" +
                 "K2;K2.csv;controls;open;16;61;;left\n" + "K3;K3.csv;controls;open;168;61;;left\n");
  const std::string call = "identify --quiet --json --study " + folder / "studie.csv";
  const Result result = run_decid(call + " --table " + folder / "wide.csv" + " --long " + folder / "long.csv" +
                                  " --report " + folder / "r.html" + " --figures " + folder / "figures");
  CAPTURE(result.err);
  CHECK(result.code == 2);
  const Json json = Json::parse(result.out);
  REQUIRE(json["recordings"].size() == 5);
  CHECK(json["recordings"][0]["participant_id"] == who);
  CHECK(json["recordings"][1]["condition"] == "closed");
  CHECK(json["recordings"][2]["columns"]["Hand"] == "=left");
  CHECK(contains(json["recordings"][3]["error"].get<std::string>(), "'16'"));
  CHECK(contains(json["recordings"][4]["error"].get<std::string>(), "K3.csv"));
  CHECK(json["recordings"][0]["body"] == json["recordings"][1]["body"]);
  CHECK(json["study"]["columns"] == Json::array({"Hand"}));
  const Json inverted =
      run_json("identify --quiet --json --invert sway --mass 61.5 --height 1.68 '" + folder / "Gruppe B/K1.csv" + "'");
  CHECK(without_study(json["recordings"][2])["parameters"] == inverted["recordings"][0]["parameters"]);

  for (const char* figure : {"estimates", "conditions", "responses"}) {
    CHECK(read_text(folder / ("figures/" + std::string(figure) + ".svg")).starts_with("<svg "));
    CHECK(contains(read_text(folder / ("figures/" + std::string(figure) + ".csv")), who));
  }
  CHECK_FALSE(std::filesystem::exists(folder / "figures/sessions.svg"));

  const auto wide = cells_of(read_text(folder / "wide.csv"), ',');
  REQUIRE(wide.size() == 6);
  CHECK(wide[0].back() == "error");
  CHECK(cell(wide, 1, "participant_id") == who);
  CHECK(cell(wide, 3, "Hand") == "'=left");  // no formula
  CHECK(cell(wide, 3, "mass_kg") == "61.5");
  CHECK(cell(wide, 3, "height_m") == "1.68");
  const Json& kp = json["recordings"][0]["parameters"][0];
  CHECK(std::stod(cell(wide, 1, "Kp_sd")) == kp["sd"]);
  CHECK(near(std::stod(cell(wide, 1, "Kp_normalized")), kp["normalized"].get<double>(), 1e-14));
  CHECK(cell(wide, 1, "theta_normalized").empty());
  CHECK(cell(wide, 1, "model_sha256") == json["model_sha256"].get<std::string>());
  CHECK(cell(wide, 1, "decid") == DECID_VERSION);
  CHECK(cell(wide, 4, "group") == "controls");

  const auto tall = cells_of(read_text(folder / "long.csv"), ',');
  REQUIRE(tall.size() == 1 + 3 * 7 + 2);
  for (std::size_t p = 0; p < 7; ++p) {
    const Json& parameter = json["recordings"][1]["parameters"][p];
    const std::size_t row = 8 + p;
    CHECK(cell(tall, row, "parameter") == parameter["name"].get<std::string>());
    CHECK(cell(tall, row, "unit") == parameter["unit"].get<std::string>());
    CHECK(std::stod(cell(tall, row, "value")) == parameter["value"]);
    CHECK(std::stod(cell(tall, row, "low50")) == parameter["interval50"][0]);
    CHECK(std::stod(cell(tall, row, "high90")) == parameter["interval90"][1]);
    CHECK(cell(tall, row, "condition") == "closed");
    CHECK(cell(tall, row, "trust") == json["recordings"][1]["trust"].get<std::string>());
    CHECK(cell(tall, row, "rhat").empty());
  }
  CHECK(cell(tall, 22, "parameter").empty());
  CHECK(contains(cell(tall, 23, "error"), "K3.csv"));

  run_decid(call + " --excel comma --table " + folder / "e.csv" + " --long " + folder / "e.xlsx");
  const std::string excel = read_text(folder / "e.csv");
  CHECK(excel.starts_with("\xEF\xBB\xBF"));
  CHECK(contains(excel, "\r\n"));
  const auto comma = cells_of(excel, ';');
  CHECK(cell(comma, 3, "mass_kg") == "61,5");
  std::string kp_text = cell(comma, 1, "Kp");
  std::ranges::replace(kp_text, ',', '.');
  CHECK(std::stod(kp_text) == kp["value"]);
  const auto sheet = cells_of(decid::recording::read_xlsx(read_text(folder / "e.xlsx"), "e.xlsx").text, '\t');
  REQUIRE(sheet.size() == tall.size());
  CHECK(sheet[0] == tall[0]);
  CHECK(near(std::stod(cell(sheet, 8, "value")), json["recordings"][1]["parameters"][0]["value"].get<double>(), 1e-12));
  CHECK(cell(sheet, 8, "participant_id") == who);

  check_refused("identify --study " + folder / "studie.csv" + " --excel comma", "--excel");
}

TEST_CASE("identify --study: a sheet's column with the name of a result keeps the result's column apart") {
  const Folder folder;
  simulate(folder / "a.csv", "--seed 3");
  write_text(folder / "s.csv", "participant_id,file,Kp,trust,value,age\na,a.csv,800,yes,7,30\n");
  run_ok("identify --quiet --study " + folder / "s.csv" + " --table " + folder / "wide.csv" + " --long " +
         folder / "long.csv");
  const auto wide = cells_of(read_text(folder / "wide.csv"), ',');
  CHECK(std::ranges::count(wide[0], "Kp") == 1);
  CHECK(cell(wide, 1, "sheet_Kp") == "800");
  CHECK(cell(wide, 1, "trust") == "usable");
  CHECK(cell(wide, 1, "sheet_trust") == "yes");
  CHECK(cell(wide, 1, "value") == "7");  // no result of this table
  CHECK(cell(wide, 1, "age") == "30");
  const auto tall = cells_of(read_text(folder / "long.csv"), ',');
  CHECK(cell(tall, 1, "sheet_value") == "7");
  CHECK(cell(tall, 1, "Kp") == "800");
}

TEST_CASE("a sheet is a table of groups, too; n/a is no group") {
  const Folder folder;
  std::string sheet = "participant_id\tgroup\tfile\n";
  for (int i = 0; i < 4; ++i) {
    const std::string file = std::to_string(i) + ".csv";
    simulate(folder / file, "--seed " + std::to_string(i));
    sheet += "p" + std::to_string(i) + '\t' +
             (i == 3   ? "n/a"
              : i == 2 ? "b"
                       : "a") +
             '\t' + (i == 0 ? "0.CSV" : file) + '\n';  // as forgiving as the sheet is
  }
  const std::string path = write_text(folder / "s.tsv", sheet).string();
  const Json json =
      run_json("identify --quiet --json --study " + path + " --group " + path + " --table " + folder / "t.csv");
  REQUIRE(json["groups"].size() == 2);
  CHECK(json["groups"][0]["participants"] == 2);
  CHECK(json["recordings"][0]["participant_id"] == "p0");
  CHECK(json["recordings"][3]["group"].is_null());
  const auto rows = cells_of(read_text(folder / "t.csv"), ',');
  CHECK(cell(rows, 3, "group") == "b");
  CHECK(cell(rows, 4, "group").empty());

  const std::string call = "identify --study " + path + " --group " + path;
  CHECK(contains(run_ok(call).err, "note: without a group, and so not compared: 1 recording\n"));
  write_text(path, "participant_id,group,file\np0,a,0.csv\n,,1.csv\np2,b,2.csv\n");
  check_refused(call, "line 3: has no participant_id");
}

TEST_CASE("a study in two sessions: changes within persons, between groups, and with age") {
  const Folder folder;
  std::string sheet = "participant_id\tgroup\tsession\tcondition\tfile\tage\tweight\theight\tsex\n";
  for (int i = 0; i < 4; ++i)
    for (const char* session : {"1", "2"}) {
      const std::string file = std::to_string(i) + "_" + session + ".csv";
      simulate(folder / file,
               "--delay " + std::string(*session == '1' ? "0.1" : "0.16") + " --seed " + std::to_string(i) + session);
      sheet += "p" + std::to_string(i) + (i < 2 ? "\ta\t" : "\tb\t") + session + "\topen\t" + file + '\t' +
               std::to_string(60 + i) + ",5\t70\t1.75\t" + (i % 2 == 0 ? "F" : "M") + '\n';
    }
  const std::string path = write_text(folder / "s.tsv", sheet).string();
  const std::string study = "identify --study " + path;
  const Json both = run_json(study + " --quiet --json --group " + path + " --within session --covariates age");
  CHECK(both["groups"].size() == 4);
  CHECK(both["groups"][1]["name"] == "a, 2");
  CHECK(both["comparisons"].size() == 4);
  CHECK(both["group_comparison"]["covariates"] == Json::array({"age"}));
  CHECK(both["recordings"][1]["group"] == "a");
  const Json& model = both["hierarchical"];
  CHECK(model["groups"][3]["group"] == "b");
  CHECK(model["groups"][3]["session"] == "2");
  CHECK(model["comparisons"][0]["groups"] == Json::array({"a, 2", "a, 1"}));
  CHECK(model["comparisons"][0]["participants_in_both"] == 2);
  CHECK(model["interactions"].size() == 1);
  CHECK(model["interactions"][0]["second"] == Json::array({"b, 2", "b, 1"}));
  CHECK(model["interactions"][0]["parameters"].size() == 7);
  REQUIRE(model["covariates"].size() == 1);
  CHECK(model["covariates"][0]["mean"] == 62.0);
  CHECK(model["covariates"][0]["unknown"] == 0);
  CHECK(model["covariates"][0]["parameters"][6]["probability_of_direction"].get<double>() >= 0.5);

  // Without groups all persons are compared with themselves. A later delay is found in four of them.
  const Result result =
      run_ok(study + " --quiet --within session -o " + folder / "o.json" + " --report " + folder / "r.html");
  CHECK(contains(result.out, "2 minus 1, 4 people in both"));
  const Json within = read_json(folder / "o.json");
  CHECK(within["recordings"][0]["group"] == "a");  // by the sheet
  CHECK(within["hierarchical"]["comparisons"].size() == 1);
  CHECK(within["hierarchical"]["comparisons"][0]["parameters"][6]["interval95"][0].get<double>() > 0.0);
  CHECK(within["hierarchical"]["changes"].size() == 4);
  run_ok("rerun --quiet " + folder / "o.json");
}

TEST_CASE("an error of a person's line is printed once for all recordings of this person") {
  const Folder folder;
  for (const char* name : {"p1_a.csv", "p1_b.csv", "p1_c.csv"}) write_text(folder / name, "time,sway_deg\n0,1\n");
  write_text(folder / "s.csv", "participant_id,weight,height\np1,heavy,1.7\n");
  const Result result = run_decid("identify --study " + folder / "s.csv");
  CHECK(result.code == 2);
  CHECK(std::ranges::count(result.err, '\n') == 2);  // the error, and how many recordings failed
  CHECK(contains(result.err, "3 recordings"));
}

TEST_CASE("one error of many lines of a sheet is printed once, with the lines") {
  const Folder folder;
  std::string sheet = "file,invert\n";
  for (int i = 0; i < 14; ++i) {
    const std::string name = std::to_string(i) + ".csv";
    write_text(folder / name, "time,sway_deg\n0,1\n");
    sheet += name + (i == 5 ? ",down\n" : ",up\n");
  }
  write_text(folder / "s.csv", sheet);
  const Result result = run_decid("identify --study " + folder / "s.csv");
  CHECK(result.code == 2);
  CHECK(std::ranges::count(result.err, '\n') == 3);
  CHECK(contains(result.err, "s.csv, lines 2, 3, 4, 5, 6, 8, 9, 10, 11, 12 and 3 others: "));
  CHECK(contains(result.err, "(13 recordings)"));
  CHECK(contains(result.err, "s.csv, line 7: "));
}

TEST_CASE("fit: a study of two bodies and two protocols, each with the bits of a call of its own" *
          doctest::test_suite("long")) {
  const Folder folder;
  const std::string wide =
      write_text(folder / "wide.json", R"({"sequence": {"cycles": 1, "amplitude_deg": 2}})").string();
  simulate(folder / "a.csv", "--protocol short --seed 1");
  simulate(folder / "b.csv", "--protocol " + wide + " --seed 2");
  write_text(folder / "s.csv",
             "participant_id,file,height,weight,protocol\nA,a.csv,1.75,70,short\nB,b.csv,1.62,58,wide.json\n");
  const std::string options = " --quiet --json --max-draws 8 --seed 3";
  const Result study = run_decid("fit" + options + " --study " + folder / "s.csv" + " -o " + folder / "o.json");
  const Json json = Json::parse(study.out);
  REQUIRE(json["recordings"].size() == 2);
  const Json a = run_json("fit" + options + " --mass 70 --height 1.75 --protocol short " + folder / "a.csv"),
             b = run_json("fit" + options + " --mass 58 --height 1.62 --protocol " + wide + " " + folder / "b.csv");
  CHECK(without_study(json["recordings"][0]) == a["recordings"][0]);
  CHECK(without_study(json["recordings"][1]) == b["recordings"][0]);
  CHECK(json["recordings"][1]["protocol"] == "wide");
  CHECK(json["study"]["protocols"].size() == 2);
  CHECK(json["seed"] == 3);

  run_ok("rerun " + folder / "o.json" + " -o " + folder / "again.json");
  CHECK(read_text(folder / "again.json") == read_text(folder / "o.json"));
}

TEST_CASE("fit: draws in Stan's form, as R's package posterior reads them") {
  const Folder folder;
  const std::string protocol = with_brief_protocol(folder);
  simulate(folder / "a.csv", protocol + "--seed 1");
  simulate(folder / "b.csv", protocol + "--seed 2");
  const Json json = Json::parse(run_ok("fit --quiet --json --max-draws 8" + protocol + folder / "a.csv" + " " +
                                       folder / "b.csv" + " --draws " + folder / "d.csv")
                                    .out);
  // Numbers from 1.
  const auto draws = cells_of(read_text(folder / "d.csv"), ',');
  REQUIRE(draws.size() == 1 + 2 * 64);
  CHECK(draws[0][0] == "file");
  CHECK(draws[0][1] == ".chain");
  double mean = 0.0;
  for (std::size_t row = 1; row <= 64; ++row) {
    CHECK(cell(draws, row, ".draw") == std::to_string(row));
    CHECK(cell(draws, row, ".chain") == std::to_string((row - 1) / 8 + 1));
    CHECK(cell(draws, row, ".iteration") == std::to_string((row - 1) % 8 + 1));
    CHECK(std::isfinite(std::stod(cell(draws, row, "lp__"))));
    const double acceptance = std::stod(cell(draws, row, "accept_stat__"));
    CHECK((acceptance >= 0.0 && acceptance <= 1.0));
    mean += std::stod(cell(draws, row, "Kp")) / 64.0;
  }
  CHECK(near(mean, json["recordings"][0]["parameters"][0]["value"].get<double>(), 1e-12));
  const Json& diagnostics = json["recordings"][0]["diagnostics"];
  CHECK(diagnostics["tail_effective_draws"]["Kp"].get<double>() > 0.0);
  CHECK(diagnostics["monte_carlo_error"]["Kp"].get<double>() <
        json["recordings"][0]["parameters"][0]["sd"].get<double>());
}

TEST_CASE(
    "a study's JSON: no body of all if the bodies differ; rerun refuses a file that was missing and is there now") {
  const Folder folder;
  for (const char* name : {"a.csv", "b.csv"}) simulate(folder / name, "--seed 5");
  const auto body_of = [&](const std::string& lines) {
    write_text(folder / "s.csv", "participant_id,file,height,weight\n" + lines);
    run_decid("identify --quiet --study " + folder / "s.csv" + " -o " + folder / "o.json");
    return read_json(folder / "o.json").at("body");
  };
  CHECK(body_of("A,a.csv,1.75,70\nB,b.csv,1.75,70\n").at("assumed") == false);
  CHECK(body_of("A,a.csv,1.75,70\nB,b.csv,1.62,58\n").is_null());
  CHECK(body_of("A,a.csv,,\nB,b.csv,,\nC,c.csv,1.75,70\n").at("assumed") == true);  // c.csv is missing
  run_ok("rerun " + folder / "o.json");
  simulate(folder / "c.csv", "--seed 6");
  check_refused("rerun " + folder / "o.json", "c.csv");
  CHECK(contains(run_decid("rerun " + folder / "o.json").err, "is there now"));
}

TEST_CASE("rerun: the same bytes; a changed result is noticed") {
  const Folder folder;
  simulate(folder / "t.csv", "--seed 5");
  run_ok("identify --quiet " + folder / "t.csv" + " --detrend offset -o " + folder / "o.json" + " --table " +
         folder / "table.csv");
  const Json json = read_json(folder / "o.json");
  CHECK(json["command"] == "identify");
  CHECK(json["arguments"] == Json::array({"--detrend=offset", folder / "t.csv"}));
  CHECK(json["inputs"][0]["sha256"].get<std::string>().size() == 64);
  CHECK(json["seed"].is_null());
  const Result result = run_ok("rerun " + folder / "o.json" + " -o " + folder / "again.json");
  CHECK(contains(result.err, "the same bytes"));
  CHECK(read_text(folder / "again.json") == read_text(folder / "o.json"));
  run_ok("rerun --quiet --threads 1 " + folder / "o.json");

  std::string changed = read_text(folder / "o.json");
  changed.replace(changed.find("\"peak_to_peak_deg\": "), 20, "\"peak_to_peak_deg\": 1");
  write_text(folder / "changed.json", changed);
  CHECK(run_decid("rerun " + folder / "changed.json").code == 1);
  check_refused("rerun " + folder / "o.json" + " -o " + folder / "none/again.json", "again.json");

  // Edited JSON, and a name that JSON cannot hold.
  const auto edited = [&](const std::string& key, const Json& value) {
    Json other = json;
    (key == "arguments" ? other["arguments"][0] : other["inputs"][0][key]) = value;
    write_text(folder / "edited.json", other.dump());
    return "rerun " + folder / "edited.json";
  };
  check_refused(edited("file", 5), "edited.json");
  check_refused(edited("sha256", 5), "edited.json");
  check_refused(edited("file", "t\xEF\xBF\xBD.csv"), "not UTF-8");
  for (const char* help : {"-h", "--help"})
    check_refused(edited("arguments", help) + " -o " + folder / "help.json", help);
  CHECK_FALSE(std::filesystem::exists(folder / "help.json"));

  // A recording that cannot be used is part of the result.
  write_text(folder / "short.csv", "time,sway_deg\n0,0\n0.01,1\n0.02,0\n");
  CHECK(run_decid("identify --quiet " + folder / "t.csv" + " " + folder / "short.csv" + " -o " + folder / "two.json")
            .code == 2);
  run_ok("rerun " + folder / "two.json");
}
