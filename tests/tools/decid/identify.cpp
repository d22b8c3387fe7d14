// decid identify as users and scripts rely on it: which recordings it reads, what it writes, and what it notices.

#include <algorithm>
#include <cmath>
#include <tuple>

#include "base/text.hpp"
#include "sim/body_model.hpp"
#include "sim/protocol/protocol.hpp"
#include "tests/tools/decid/run.hpp"

using namespace decid::test;
using Json = nlohmann::json;

TEST_CASE("identify makes the sway of leg and trunk, and reads standard input") {
  const Folder folder;
  run_ok("simulate --model dip -o " + folder / "d.csv");
  const auto values = [](const std::string& command) {
    std::vector<double> found;
    const Json recording = first_recording("identify --json " + command);
    for (const Json& parameter : recording["parameters"]) found.push_back(parameter["value"].get<double>());
    return found;
  };
  const auto whole = values(folder / "d.csv"), parts = values("--leg leg_deg --trunk trunk_deg " + folder / "d.csv");
  REQUIRE(whole.size() == decid::sim::single_pendulum().parameters.size());
  for (std::size_t p = 0; p < whole.size(); ++p) CHECK(near(parts[p], whole[p], 1e-4));
  CHECK(values("- < " + folder / "d.csv") == whole);
}

TEST_CASE("files may be pipes, as the shell's <(command) makes them") {
  const Folder folder;
  run_ok("simulate -o " + folder / "t.csv");
  const auto piped = [&](const std::string& file, const std::string& arguments) {
    return run_ok(arguments + ")", "cat " + file + " | (exec 3<&0; ");
  };
  const std::string model = std::string(DECID_SOURCE_DIR) + "/models/firmware.safetensors";
  const auto answer = [](const Result& run) { return Json::parse(run.out)["recordings"].at(0).at("parameters"); };
  const Json plain = answer(run_ok("identify --json " + folder / "t.csv"));
  CHECK(answer(piped(folder / "t.csv", "identify --json /dev/fd/3 -o " + folder / "o.json")) == plain);
  CHECK(answer(piped(model, "identify --json --model /dev/fd/3 " + folder / "t.csv" + " -o " + folder / "o.json")) ==
        answer(run_ok("identify --json --model " + model + " " + folder / "t.csv")));
  write_text(folder / "architecture", "fc 7\n");
  const std::string training =
      "train --stream --stream-trials 32 --validation-trials 16 --batch 16 --epochs 1 --quiet "
      "--preset firmware --architecture ";
  run_ok(training + folder / "architecture" + " -o " + folder / "file.safetensors");
  piped(folder / "architecture", training + "/dev/fd/3 -o " + folder / "pipe.safetensors");
  CHECK(read_text(folder / "pipe.safetensors") == read_text(folder / "file.safetensors"));
}

TEST_CASE("identify names files left out of a folder, unless --quiet") {
  const Folder folder;
  std::filesystem::create_directories(folder / "in/day1");
  run_ok("simulate -o " + folder / "in/t.csv");
  run_ok("simulate --seed 2 -o " + folder / "in/day1/u.csv");
  write_text(folder / "in/participants.tsv", "participant_id\n");
  const auto run = run_ok("identify " + folder / "in");
  CHECK(run.err.starts_with("note: left out: "));
  const auto all = run_decid("identify --json --quiet --recursive " + folder / "in");
  CHECK(all.err.empty());
  CHECK(Json::parse(all.out)["recordings"].size() == 2);
  CHECK_FALSE(Json::parse(all.out)["options"].contains("--recursive"));
}

TEST_CASE("identify prints, writes JSON and a report") {
  const Folder folder;
  const std::string trial = folder / "trial.csv";
  run_ok("simulate --seed 3 -o " + trial);
  const auto text = run_ok("identify " + trial + " -o " + folder / "out.json" + " --report " + folder / "out.html");
  CHECK(contains(text.out, "Kp_pass"));
  CHECK(run_decid("identify --quiet " + trial).out == text.out);  // quiet silences messages, not results
  const auto printed = run_decid("identify " + trial + " --json");
  CHECK(printed.err.empty());
  CHECK(printed.out == read_text(folder / "out.json"));

  const Json json = Json::parse(printed.out);
  CHECK(json.at("decid") == DECID_VERSION);
  CHECK(json.at("model_sha256").get<std::string>().size() == 64);
  CHECK(json.at("other_answer").at("command") == "decid fit");
  CHECK(json.at("options").empty());
  CHECK(json.at("protocol").at("name") == "default");
  CHECK(run_json("identify --json --quiet --unit deg --detrend offset " + trial).at("options") ==
        Json{"--unit deg", "--detrend offset"});
  const Json& recording = json.at("recordings").at(0);
  CHECK(recording.at("file") == trial);
  CHECK(recording.at("peak_to_peak_deg").get<double>() > 0.0);
  CHECK(recording.at("fit").at("rms_residual_deg").is_number());
  CHECK(recording.at("fit").at("variance_accounted_for").is_number());
  CHECK(recording.at("warnings").is_array());
  CHECK(recording.at("trust") == "usable");
  REQUIRE(recording.at("parameters").size() == 7);
  for (std::size_t p = 0; p < 7; ++p) {
    const auto& info = decid::sim::single_pendulum().parameters[p];
    const Json& parameter = recording.at("parameters").at(p);
    CHECK(parameter.at("name") == info.name);
    CHECK(parameter.at("unit") == info.unit);
    CHECK(near(parameter.at("range").at(1).get<double>(), info.high, 1e-15));
    if (info.scales_with_mgh)
      CHECK(near(parameter.at("normalized").get<double>(),
                 parameter.at("value").get<double>() / decid::sim::Body{}.mgh(), 1e-15));
    else
      CHECK(parameter.at("normalized").is_null());
  }
  CHECK(contains(read_text(folder / "out.html"), "Passive stiffness"));
}

TEST_CASE("one bad recording of several does not stop the others") {
  const Folder folder;
  run_ok("simulate --seed 3 -o " + folder / "a.csv");
  write_text(folder / "bad.csv", "time,sway\n0,1\n0.01,x\n");
  const std::string files = folder / "bad.csv" + " " + folder / "a.csv";
  const auto both =
      run_decid("identify --json " + files + " -o " + folder / "o.json" + " --report " + folder / "o.html");
  CHECK(both.code == 2);
  CHECK(std::count(both.err.begin(), both.err.end(), '\n') == 2);
  CHECK(contains(both.err, "line 3, sway: 'x'"));
  CHECK(contains(both.err, "1 of 2 recordings failed"));
  const Json recordings = Json::parse(both.out).at("recordings");
  REQUIRE(recordings.size() == 2);
  CHECK(recordings[0].at("file") == folder / "bad.csv");
  CHECK(contains(recordings[0].at("error").get<std::string>(), "line 3, sway: 'x'"));
  CHECK_FALSE(recordings[0].contains("parameters"));
  CHECK(recordings[1] == run_json("identify --json " + folder / "a.csv").at("recordings")[0]);
  CHECK(read_text(folder / "o.json") == both.out);
  CHECK(contains(read_text(folder / "o.html"), "line 3, sway: 'x'"));
}

TEST_CASE("the frequency response is in the JSON, and a sway that does not follow the tilt is noticed") {
  const Folder folder;
  run_ok("simulate --nv 0.3 --theta 0 --seed 4 -o " + folder / "a.csv");
  const Json recording = first_recording("identify --json " + folder / "a.csv");
  const Json& frf = recording.at("frf");
  CHECK(frf.at("cycles") == 2);
  const std::size_t bands = frf.at("frequency_hz").size();
  REQUIRE(bands > 12);
  int coherent = 0;
  for (const auto& item : frf.items()) {
    const std::string& key = item.key();
    const Json& values = item.value();
    if (!values.is_array()) continue;
    CAPTURE(key);
    CHECK(values.size() == bands);
  }
  for (std::size_t i = 0; i < bands; ++i) {
    CHECK(frf["gain_low"][i].get<double>() <= frf["gain"][i].get<double>());
    CHECK(frf["gain_high"][i].get<double>() > frf["gain"][i].get<double>());
    CHECK(std::abs(frf["phase_deg"][i].get<double>() - frf["linear_phase_deg"][i].get<double>()) <= 180.001);
    CHECK(frf["coherence"][i].get<double>() <= 1.0);
    if (frf["coherence"][i].get<double>() > 0.5) ++coherent;
  }
  CHECK(coherent > 3);
  CHECK(recording["response_ratio"] > 0.7);
  CHECK_FALSE(contains(recording["warnings"].dump(), "out_of_distribution"));

  // The platform stood still: sway of the vestibular noise alone.
  write_text(folder / "still.json", R"({"sequence": {"amplitude_deg": 1e-6}})");
  run_ok("simulate --seed 3 --protocol " + folder / "still.json" + " -o " + folder / "b.csv");
  const Json still = first_recording("identify " + folder / "b.csv --json");
  CHECK(still["response_ratio"] < 0.6);
  CHECK(still["trust"] == "not usable");
  CHECK(still["warnings"][0]["code"] == "out_of_distribution");
  CHECK(still["warnings"][0]["severity"] == "invalid");
}

TEST_CASE("a measured tilt puts a recording that started early in time") {
  const Folder folder;
  run_ok("simulate --seed 3 -o " + folder / "a.csv");
  std::string header, early = "time,tilt_deg,com_sway_deg\n";
  const auto rows = read_csv(folder / "a.csv", header);
  char cells[96];
  for (std::size_t k = 0; k < rows.size() + 500; ++k) {
    const auto& row = rows[k < 300 ? 0 : std::min(k - 300, rows.size() - 1)];
    std::snprintf(cells, sizeof cells, "%.2f,%.9f,%.9f\n", 0.01 * static_cast<double>(k), row[2], row[1]);
    early += cells;
  }
  write_text(folder / "early.csv", early);
  const Json plain = first_recording("identify --json " + folder / "a.csv");
  const Json timed = first_recording("identify --json --tilt-column tilt_deg " + folder / "early.csv");
  CHECK(near(timed.at("tilt").at("delay_s").get<double>(), 3.0, 1e-9));  // the digits in the file
  CHECK(timed.at("tilt").at("correlation").get<double>() > 0.9999);
  CHECK(near(timed.at("tilt").at("gain").get<double>(), 1.0, 1e-9));
  const Json told = first_recording("identify --json --start 3 " + folder / "early.csv");
  CHECK(told.at("parameters") == timed.at("parameters"));
  for (std::size_t p = 0; p < 7; ++p) {  // but for the digits in the file
    const auto& info = decid::sim::single_pendulum().parameters[p];
    CHECK(std::abs(timed["parameters"][p]["value"].get<double>() - plain["parameters"][p]["value"].get<double>()) <
          1e-3 * (info.high - info.low));
  }
}

TEST_CASE("a single recording that cannot be used: JSON and tables have its error, a report is not written") {
  const Folder folder;
  const std::string cut = write_text(folder / "cut.csv", "time_s,sway_deg\n0,0\n0.05,1\n0.1,0\n").string(),
                    none = folder / "none.csv";
  for (const auto& [command, file, code] :
       {std::tuple("identify ", cut, "recording_too_short"), {"fit --max-draws 8 ", none, "file_missing"}}) {
    const std::string call = command + file;
    const Result plain = run_decid(call), written = run_decid(call + " --json -o " + folder / "o.json" + " --table " +
                                                              folder / "t.csv" + " --report " + folder / "r.html");
    CAPTURE(call);
    CAPTURE(written.err);
    CHECK(plain.code == 2);
    CHECK(plain.out.empty());
    CHECK(written.code == 2);
    CHECK(written.err == plain.err);
    const Json json = Json::parse(written.out);
    CHECK(read_text(folder / "o.json") == written.out);
    REQUIRE(json["recordings"].size() == 1);
    CHECK(json["recordings"][0]["file"] == file);
    CHECK(json["recordings"][0]["code"] == code);
    CHECK("decid: " + json["recordings"][0]["error"].get<std::string>() + "\n" == plain.err);
    CHECK(decid::test::contains(read_text(folder / "t.csv"), file));
    CHECK_FALSE(std::filesystem::exists(folder / "r.html"));
  }
}

TEST_CASE("recordings without a fit leave the file of draws as it was; a file named behind -- is found again") {
  const Folder folder;
  const std::string none = folder / "none.csv", draws = write_text(folder / "d.csv", "before").string();
  CHECK(run_decid("fit --max-draws 8 " + none + " " + folder / "no.csv" + " --draws " + draws).code == 2);
  CHECK(read_text(draws) == "before");

  const std::string here = "cd " + folder / "." + " && ";
  run_ok("simulate --seed 3 -o ./-x.csv", here);
  run_ok("identify --quiet -o m.json -- -x.csv", here);
  CHECK(Json::parse(read_text(folder / "m.json"))["arguments"] == Json{"--", "-x.csv"});
  run_ok("rerun m.json", here);
}

TEST_CASE("an output option that names the standard output has it for itself") {
  const Folder folder;
  run_ok("simulate -o " + folder / "a.csv");
  const std::string call = "identify " + folder / "a.csv" + " --quiet ";
  const std::string json = run_ok(call + "--json").out, table = run_ok(call + "--table /dev/stdout").out;
  CHECK(run_ok(call + "-o /dev/stdout").out == json);        // a file
  CHECK(run_ok(call + "-o /dev/stdout | cat").out == json);  // a pipe
  CHECK(run_ok(call + "-o /proc/self/fd/1").out == json);
  CHECK(std::ranges::count(table, '\n') == 2);  // the names and the recording
  CHECK(run_decid(call + "--json --table /dev/stdout").code == 2);
  CHECK(decid::test::contains(run_ok(call + "-o " + folder / "o.json").out, "Kp"));
}

TEST_CASE("the JSON has the person's mass and height as they were given") {
  const Folder folder;
  run_ok("simulate -o " + folder / "a.csv");
  for (const auto& [mass, height] : {std::pair(70.0, 1.75), {62.3, 1.6}, {101.25, 1.93}}) {
    const Json person = run_json(decid::format("identify --json --quiet --mass %g --height %g ", mass, height) +
                                 folder / "a.csv")["body"]["participant"];
    CHECK(person["mass_kg"] == mass);
    CHECK(person["height_m"] == height);
  }
}
