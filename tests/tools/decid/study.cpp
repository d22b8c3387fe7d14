// decid study: another command, or the study's own tables, confirm every number. All its files exist.

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "sim/body_model.hpp"
#include "tests/tools/decid/run.hpp"
#include "tools/report/figures/svg.hpp"

using namespace decid::test;
using Json = nlohmann::json;

namespace {

/// A column of a CSV file.
std::vector<double> column(const std::string& path, const std::string& name) {
  const Cells rows = cells_of(read_text(path));
  std::vector<double> values;
  for (std::size_t row = 1; row < rows.size(); ++row)
    values.push_back(std::strtod(cell(rows, row, name).c_str(), nullptr));
  return values;
}

double sum(const std::vector<double>& values) {
  double total = 0;
  for (const double v : values) total += v;
  return total;
}

/// A tiny data set, a model of it and a recording.
struct Setting {
  Folder folder;
  std::string data = folder / "d.npz", model = folder / "m.safetensors", recording = folder / "r.csv",
              protocol = folder / "quick.json";

  Setting() {
    write_text(protocol, R"({"name": "quick", "sequence": {"feedback": [0, 0, -1, 1], "start": [0, 0, 0, 1],
                             "offset_s": 0, "cycles": 1, "amplitude_deg": 2}})");
    run_ok("dataset --count 60 --base 50 --seed 5 --protocol " + protocol + " -o " + data);
    run_ok("train --preset small --epochs 4 --patience 4 --data " + data + " -o " + model);
    run_ok("simulate --model dip --protocol " + protocol + " -o " + recording);
  }
  std::string study(const std::string& options) const {
    return "study --model " + model + " --trials 60 --realisations 3 --sensor-noise 0 0.1 " + options;
  }
};

/// Checks the bins of a study: they partition the trials, and their weighted errors give the whole error.
void check_bins(const Json& level, const std::string& key, int trials) {
  double count = 0, squares = 0;
  for (const Json& bin : level.at(key)) {
    const double in_bin = bin.at("trials");
    CHECK(bin.at("mse").is_null() == (in_bin == 0));
    if (in_bin > 0) squares += in_bin * bin.at("mse").get<double>();
    count += in_bin;
  }
  CHECK(count == trials);
  CHECK(near(squares / count, level.at("mse").get<double>(), 1e-13));  // roundings, some hundred
}

}  // namespace

TEST_CASE("a study of a model with its data set, a recording and a learning curve") {
  const Setting s;
  write_text(s.folder / "curve.csv", "trials,mse\n100,0.9\n1000,0.6\n10000,0.45\n");
  const std::string out = s.folder / "study";
  const auto result =
      run_decid(s.study("--json --quiet --data " + s.data + " --recording " + s.recording + " --learning-curve " +
                        s.folder / "curve.csv" + " --time training=12.5 --time simulation=3 -o " + out));
  CAPTURE(result.err);
  REQUIRE(result.code == 0);
  CHECK(result.err.empty());
  CHECK(result.out == read_text(out + "/study.json"));
  const Json json = Json::parse(result.out);

  for (const std::string half : {"training", "validation"}) {
    Json other =
        without_call(run_json("evaluate --json --split " + half + " --model " + s.model + " --data " + s.data));
    other.erase("models");
    CHECK(json.at("errors").at(half) == other);
  }
  CHECK(json.at("data_set").at("trials") == 60);
  CHECK(json.at("data_set").at("base_trials") == 50);
  CHECK(json.at("training").at("epochs") == 4);
  CHECK(json.at("seconds").at("training") == 12.5);
  CHECK(json.at("learning_curve").size() == 3);
  CHECK(json.at("paper").at("validation_loss") == 0.2851);
  // The paper's standard deviations: theta's and Kd_pass's exceed half of their range, which no distribution can.
  const Json& stddevs = json.at("paper").at("sd");
  for (const std::string name : {"theta", "Kd_pass"}) {
    const auto info =
        *std::ranges::find(decid::sim::single_pendulum().parameters, name, &decid::sim::ParameterInfo::name);
    CHECK(stddevs.at(name).get<double>() > 0.5 * (info.high - info.low));
  }
  const double guess = json.at("mse_by_paper_sd").at("mean_guess");
  CHECK(guess > 0.4);
  CHECK(guess < 0.7);
  CHECK(json.at("mse_by_paper_sd").at("validation").get<double>() <
        json.at("errors").at("validation").at("mse").get<double>());

  // The log's best epoch is the one kept, and its error that of the finished model.
  const auto validation = column(out + "/loss.csv", "validation_mse");
  const int kept = json.at("training").at("kept_epoch");
  CHECK(validation.size() == 4);
  CHECK(validation.at(static_cast<std::size_t>(kept - 1)) == *std::ranges::min_element(validation));
  // The log has 9 digits.
  CHECK(near(validation.at(static_cast<std::size_t>(kept - 1)),
             json.at("errors").at("validation").at("mse").get<double>(), 5e-9));

  CHECK(sum(column(out + "/amplitude-histogram.csv", "before")) == 50);
  CHECK(sum(column(out + "/amplitude-histogram.csv", "after")) == 60);

  REQUIRE(json.at("worth").size() == 2);
  CHECK(json.at("worth").at(0).at("mse") == json.at("errors").at("fresh").at("mse"));
  CHECK(json.at("worth").at(0).at("mse") != json.at("worth").at(1).at("mse"));
  for (const Json& level : json.at("worth")) {
    check_bins(level, "by_amplitude_deg", 60);
    check_bins(level, "by_nv", 60);
  }

  const Json identified = run_json("identify --json --model " + s.model + " " + s.recording);
  for (std::size_t p = 0; p < 7; ++p)
    CHECK(json.at("recording").at("identified").at(decid::sim::single_pendulum().parameters[p].name) ==
          identified.at("recordings").at(0).at("parameters").at(p).at("value"));
  CHECK(json.at("double_pendulum").at("squared_errors").size() == 3);
  CHECK(json.at("double_pendulum").at("squared_errors").at(0) == json.at("double_pendulum").at("squared_error"));
  CHECK(json.at("double_pendulum").at("true").at("Nv") == 0.5);

  // The sample is the trial in the middle: its squared error is 7 times its own MSE.
  const double error = json.at("sample").at("squared_error");
  CHECK(near(error, 7 * json.at("sample").at("mean_squared_error").get<double>(), 1e-15));
  const auto sway = column(out + "/sample.csv", "sway_deg");
  const auto [low, high] = std::ranges::minmax(sway);
  // The table has 8 digits.
  CHECK(near((high - low) * M_PI / 180, json.at("sample").at("peak_to_peak_rad").get<double>(), 1e-7));
  CHECK(sum(column(out + "/activations.csv", "filter_8")) != 0);  // the preset's first layer has 8

  for (const std::string id : {"amplitude-histogram", "input-image", "activations", "loss", "sample", "double-pendulum",
                               "recording", "error-by-amplitude", "error-by-noise", "learning-curve"}) {
    CAPTURE(id);
    const std::string svg = read_text(out + "/" + id + ".svg");
    CHECK(svg.starts_with("<svg "));
    CHECK(svg.ends_with("</svg>\n"));
    CHECK(contains(read_text(out + "/" + id + ".csv"), "\n"));
    CHECK(contains(read_text(out + "/report.html"), "\"id\":\"" + id + "\""));
  }
  for (const char* printed : {"0.2851", "12766", "Kp_pass"}) CHECK(contains(read_text(out + "/table.txt"), printed));

  // Again: the same bytes, for any number of threads. Test trials of the data set's own seed are refused.
  const auto again = run_ok("rerun --threads 1 " + out + "/study.json");
  CHECK(contains(again.err, "the same bytes\n"));
  check_refused(s.study("--seed 5 --quiet --data " + s.data + " -o " + s.folder / "refused"), "5");
  CHECK_FALSE(std::filesystem::exists(s.folder / "refused/study.json"));
}

TEST_CASE("a study of faults: each at its sizes, on the trials of the study") {
  const Setting s;
  const std::string out = s.folder / "study";
  const auto result = run_ok("study --faults --json --quiet --model " + s.model +
                             " --trials 24 --realisations 1 --sensor-noise 0.02 -o " + out);
  const Json json = Json::parse(result.out), &faults = json.at("faults");
  const auto row = [&](const std::string& name, double size) {
    for (const Json& one : faults)
      if (one.at("fault") == name && one.at("size") == size) return one;
    FAIL("no row of " << name);
    return Json();
  };
  CHECK(faults.size() == 39);
  // The trials and their noise are those of the levels; estimates go through floats of their own units.
  CHECK(near(row("none", 0).at("mse").get<double>(), json.at("worth").at(0).at("mse").get<double>(), 1e-5));
  std::set<std::string> what;
  for (const Json& one : faults) {
    CAPTURE(one.dump());
    CHECK(what.insert(one.at("what")).second);
    CHECK(one.at("warned").get<double>() >= 0.0);
    CHECK(one.at("warned").get<double>() <= 1.0);
    CHECK_FALSE(one.contains("predicted_variance"));  // the model gives point estimates
    if (one.at("fault") == "double_pendulum") {
      CHECK(one.at("mse").is_null());
      continue;
    }
    CHECK(one.at("trials") == 24);
    CHECK((one.at("fault") == "none") == (one.at("mse") == row("none", 0).at("mse")));
  }
  CHECK(row("offset_deg", 2.0).at("warned") == 1.0);
  CHECK(row("offset_deg", 0.1).at("mse").get<double>() < row("offset_deg", 2.0).at("mse").get<double>());
  CHECK(json.at("faults_sensor_noise_deg") == 0.02);
  CHECK(json.at("notes").empty());
}

TEST_CASE("a study of faults that the protocol cannot have: notes say which and why") {
  const Folder folder;
  write_text(folder / "p.json", R"({"name": "sines", "sample_rate_hz": 20, "sines": {"cycle_s": 20, "cycles": 2,
      "components": [{"frequency_hz": 0.2, "amplitude_deg": 1}]}})");
  run_ok("train --stream --stream-trials 16 --validation-trials 8 --epochs 1 --preset small --quiet --protocol " +
         folder / "p.json" + " -o " + folder / "m.safetensors");
  const auto result = run_ok("study --faults --json --quiet --trials 4 --realisations 1 --model " +
                             folder / "m.safetensors" + " -o " + folder / "out");
  const Json json = Json::parse(result.out);
  for (const Json& row : json.at("faults")) CHECK(row.at("trials").get<int>() > 0);
  const std::string sines = json.at("notes").dump();
  CAPTURE(sines);
  CHECK(contains(sines, "twice the protocol's tilt: the tilt is not a sequence"));
  CHECK(contains(sines, "low-pass of 10 Hz: the rate is too low"));
  CHECK(contains(sines, "moving average of 0.05 s: it is below two samples"));
}

TEST_CASE("a study without a data set simulates its own trials") {
  const Setting s;
  std::filesystem::remove(s.model + ".log.csv");
  const std::string out = s.folder / "study";
  const Json json = run_json(s.study("--json --quiet -o " + out));
  CHECK(json.at("errors").at("validation").is_null());
  CHECK(json.at("data_set").is_null());
  CHECK(json.at("training").is_null());
  CHECK(json.at("recording").is_null());
  CHECK(json.at("errors").at("fresh").at("trials") == 60);
  CHECK(json.at("sample").at("from").get<std::string>().starts_with("test trials"));
  CHECK_FALSE(std::filesystem::exists(out + "/loss.svg"));
  CHECK_FALSE(std::filesystem::exists(out + "/amplitude-histogram.svg"));
  CHECK(std::filesystem::exists(out + "/error-by-amplitude.svg"));

  CHECK(json.at("command") == "study");
  CHECK(json.at("seed") == 99);
}

TEST_CASE("a study of a network of time series shows each of them, and filters in lines") {
  const Folder folder;
  run_ok("study --quiet --trials 16 --realisations 1 -o " + folder / "study");  // the built-in model
  const Cells image = cells_of(read_text(folder / "study/input-image.csv")),
              filters = cells_of(read_text(folder / "study/activations.csv"));
  REQUIRE(image.size() == 606);
  CHECK(image.front() == std::vector<std::string>{"time_s", "sway_mean", "sway_difference_2", "sway_change_mean",
                                                  "sway_change_difference_2", "sway_bend_mean",
                                                  "sway_bend_difference_2", "height", "tilt", "tilt_velocity"});
  CHECK(image[605][0] == "60.4");
  REQUIRE(filters.size() == 304);
  CHECK(filters.front().size() == 48);
}

TEST_CASE("a study reads one recording of a file of several, and --trial none reads all rows") {
  const Folder folder;
  run_ok("simulate --quiet --seed 7 -o " + folder / "r.csv");
  std::istringstream lines(read_text(folder / "r.csv"));
  std::string one, blocks;
  int number = 0;
  for (std::string line; std::getline(lines, line); ++number) {
    one += (number == 0 ? "block," : "1,") + line + "\n";
    blocks += (number == 0 ? "block," : number < 6000 ? "1," : "2,") + line + "\n";
  }
  write_text(folder / "one.csv", one);
  write_text(folder / "blocks.csv", blocks);
  const std::string study = "study --quiet --json --trials 16 --realisations 1 -o " + folder / "study";
  const auto make_recording = [&](const std::string& options) {
    const auto result = run_ok(study + " --recording " + options);
    return Json::parse(result.out).at("recording").at("identified");
  };
  const Json whole = make_recording(folder / "r.csv");
  CHECK(make_recording(folder / "blocks.csv" + " --trial none") == whole);
  CHECK(make_recording(folder / "one.csv" + " --trial block") == whole);
  check_refused(study + " --recording " + folder / "blocks.csv", "blocks.csv");
  check_refused(study + " --recording " + folder / "blocks.csv" + " --trial block", "2 recordings");
  check_refused(study + " --recording " + folder / "blocks.csv" + " --trial no", "blocks.csv");
  check_refused(study + " --trial none");
}
