// A network that says how sure it is, from its training to what the program reports.

#include <cmath>

#include "tests/tools/decid/run.hpp"

using namespace decid::test;
using Json = nlohmann::json;

TEST_CASE("a network with predicted uncertainty: trained, recalibrated, evaluated, identifying") {
  const Folder folder;
  write_text(folder / "image.json", R"({"block": 10, "channels": ["sway", "sway_change"]})");
  write_text(folder / "layers.txt", "conv 8 15x1 stride 4x1\nrelu\nstatspool\nfc 16\nrelu\nfc 36\n");
  const std::string protocol = " --protocol " + quick_protocol(folder), model = " --model " + folder / "m.safetensors";
  const auto trained = run_ok("train --stream --stream-trials 1000 --validation-trials 16 --epochs 1 --quiet" +
                              protocol + " --image " + folder / "image.json" + " --architecture " +
                              folder / "layers.txt" + " --head 'mixture 1' -o " + folder / "m.safetensors");
  const Json info = run_json("info --json " + folder / "m.safetensors");
  CHECK(info.at("head") == "mixture 1");
  CHECK(info.at("recalibrated") == true);
  const std::string ideal = "info " DECID_SOURCE_DIR "/models/spectra.safetensors";
  CHECK(contains(run_decid(ideal).out, "head      point\n"));
  CHECK(run_json(ideal + " --json").at("recalibrated") == false);

  run_ok("dataset --count 400 --seed 5" + protocol + " -o " + folder / "data.npz");
  const std::string evaluate = "evaluate" + model + " --data " + folder / "data.npz";
  const Json evaluation = run_json(evaluate + " --json");
  // Learnt from 1000 trials, seen in 400 of 7 parameters that may stand or fall together: five standard errors.
  CHECK(within(evaluation.at("coverage50").get<double>(), 0.5, 5.0 * std::sqrt(0.25 * (1.0 / 1000 + 1.0 / 400))));
  CHECK(within(evaluation.at("coverage90").get<double>(), 0.9, 5.0 * std::sqrt(0.09 * (1.0 / 1000 + 1.0 / 400))));
  // Squares of uniform values deviate by sqrt(0.8) of their mean, those of others less.
  CHECK(near(evaluation.at("predicted_variance").get<double>(), evaluation.at("mse").get<double>(),
             5.0 * std::sqrt(0.8 * (1.0 / 1000 + 1.0 / 400))));
  CHECK(evaluation.at("log_score").is_number());
  for (const char* key : {"coverage50", "coverage90", "predicted_variance", "log_score"})
    CHECK(evaluation.at(std::string(key) + "_per_parameter").size() == 7);
  CHECK(contains(run_decid(evaluate).out, "log score"));

  run_ok("simulate" + protocol + " -o " + folder / "trial.csv");
  const auto identified =
      run_decid("identify --json" + model + " --report " + folder / "r.html" + " " + folder / "trial.csv");
  REQUIRE(identified.code == 0);
  const Json recording = Json::parse(identified.out).at("recordings").at(0);
  CHECK(recording.at("correlations").size() == 7);
  for (const Json& parameter : recording.at("parameters"))
    CHECK(parameter.at("interval90")[0].get<double>() < parameter.at("interval90")[1].get<double>());
  CHECK(contains(read_text(folder / "r.html"), "\"recalibrated\":true"));
  run_ok("export c " + folder / "m.safetensors" + " --quiet -o " + folder / "out");
  CHECK(contains(read_text(folder / "out/m.h"), "int m_stddevs("));

  // The study of recording artefacts lists the predicted variance beside the error.
  const auto study = run_ok("study --faults --json --quiet --trials 12 --realisations 1 --seed 77 --model " +
                            folder / "m.safetensors" + " -o " + folder / "study");
  const Json faults = Json::parse(study.out).at("faults");
  CHECK(faults.size() > 30);
  for (const Json& row : faults) {
    CHECK(row.contains("predicted_variance") == (row.at("fault") != "double_pendulum"));
    if (!row.contains("predicted_variance")) continue;
    CHECK(row.at("predicted_variance").get<double>() > 0.0);
    CHECK(row.at("coverage50").get<double>() <= row.at("coverage90").get<double>());
    CHECK(row.at("coverage90").get<double>() <= 1.0);
  }

  // Too few trials to recalibrate: the model records that.
  const auto few = run_ok("train --stream --stream-trials 64 --validation-trials 16 --epochs 1" + protocol +
                          " --image " + folder / "image.json" + " --architecture " + folder / "layers.txt" +
                          " --head 'mixture 1' -o " + folder / "few.safetensors");
  CHECK(contains(few.err, "fewer than 1000 trials"));
  CHECK(contains(run_decid("info " + folder / "few.safetensors").out, "mixture 1, not recalibrated"));
}
