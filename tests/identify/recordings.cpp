// Warnings about recordings outside a model's training range: each occurs there, and only there.
#include "identify/recordings.hpp"

#include <cmath>
#include <fstream>

#include "identify/study/study_results.hpp"
#include "identify/training/presets.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"
#include "tests/identify/measure_response_ratio.hpp"

namespace decid {
namespace {

using test::warns;

/// An untrained network whose outputs are small: what it identifies is near the middle of the ranges.
Model middling() {
  const sim::Protocol protocol = sim::short_protocol();
  Model model(protocol, preset_named("small").image, preset_named("small").architecture);
  model.network.initialise(3);
  const auto rows = static_cast<std::size_t>(model.images().shape().channels * model.images().shape().rows);
  model.rows = {std::vector<float>(rows, 0.0F), std::vector<float>(rows, 1.0F)};
  model.targets.mean = sim::single_pendulum().parameters.middle();
  for (std::size_t p = 0; p < sim::single_pendulum().parameters.size(); ++p)
    model.targets.stddev[p] =
        1e-9 * (sim::single_pendulum().parameters[p].high - sim::single_pendulum().parameters[p].low);
  return model;
}

/// A trial of the middling controller, times `scale`, plus an offset.
RecordingResult identified(const Model& model, double scale, double offset_deg) {
  const sim::Simulator simulator(model.protocol);
  std::vector<double> sway(static_cast<std::size_t>(simulator.samples()));
  REQUIRE(simulator.run(sim::single_pendulum().parameters.middle(), Random(4, sim::streams::vestibular_noise, 0), sway)
              .valid);
  double mean = 0;
  for (const double value : sway) mean += value / static_cast<double>(sway.size());
  const test::TemporaryFolder folder;
  std::ofstream file(folder / "r.csv");
  file << "sway_deg\n";
  for (const double value : sway) file << scale * (value - mean) / sim::rad_per_deg + offset_deg << "\n";
  file.close();
  ReadOptions options;
  options.recording.rate_hz = 100.0;
  const std::vector<RecordingResult> all = identify_plan(model, "m", make_plan({folder / "r.csv"}, options)).recordings;
  REQUIRE(all.size() == 1);
  REQUIRE_FALSE(all[0].error);
  return all[0];
}

}  // namespace

TEST_CASE("identify: no warning within the training's bounds") {
  Model model = middling();
  const RecordingResult id = identified(model, 1.0, 0.7);
  CHECK(id.trust() == Trust::usable);
  for (std::size_t p = 0; p < sim::single_pendulum().parameters.size(); ++p) {
    const sim::ParameterInfo& info = sim::single_pendulum().parameters[p];
    CHECK(std::abs(id.estimate.parameters[p] - info.middle()) < 1e-3 * (info.high - info.low));
  }
}

TEST_CASE("identify: an offset of the sway, and sway beyond 5 degrees, are warned of") {
  Model model = middling();
  CHECK(warns(identified(model, 1.0, 0.9), "the sway's mean is 0.90 degrees"));
  CHECK(warns(identified(model, 1.0, -0.9), "the sway's mean is -0.90 degrees"));
  const RecordingResult large = identified(model, 10.0, 0.0);
  CHECK(warns(large, "trials beyond 5 degrees were never trained on"));
  CHECK_FALSE(warns(large, "the sway's mean"));
}

TEST_CASE("identify: a parameter more than a twentieth of its range outside is warned of by name") {
  const sim::ParameterTable& table = sim::single_pendulum().parameters;
  for (const auto& [place, outside] : {std::pair(-0.06, true), {-0.04, false}, {1.04, false}, {1.06, true}}) {
    Model model = middling();
    for (std::size_t p = 0; p < table.size(); ++p) model.targets.mean[p] = table[p].low + place * table[p].range();
    const RecordingResult found = identified(model, 1.0, 0.0);
    for (const std::string& name : table.names()) {
      CAPTURE(name);
      CHECK(warns(found, name + " = ") == outside);
    }
  }
}

TEST_CASE("identify: how a recording follows the tilt is measured with the identified parameters") {
  Model model = middling();
  const RecordingResult id = identified(model, 1.0, 0.0);
  const sim::Simulator simulator(model.protocol);
  CHECK(id.explanation.response_ratio == test::ResponseRatioAlone(simulator).measure(
                                             id.estimate.parameters, id.trial.sway_rad(), nullptr, id.trial.gaps));
  CHECK(std::isnan(id.explanation.ood_score));  // the model has learned nothing
  // Reversed, it does not follow.
  CHECK(warns(identified(model, -1.0, 0.0), "hardly follows"));
}

TEST_CASE("sources: a file is one recording, or one for each trial; one that cannot be read is one") {
  const test::TemporaryFolder folder;
  const auto file = test::write_text(folder / "long.csv", "run,time,sway\na,0,1\na,1,2\nb#,0,1\nb#,1,3\n");
  const auto none = folder / "none.csv";
  const std::vector<RecordingSource> whole = make_sources({file, none}, {});
  REQUIRE(whole.size() == 2);
  CHECK(whole[0].name() == file.string());
  const recording::RecordingOptions by_run{.trial_column = "run"};
  const std::vector<RecordingSource> trials = make_sources({file, none, file}, by_run);
  REQUIRE(trials.size() == 5);
  CHECK(trials[0].name() == file.string() + "#a");
  CHECK(trials[1].trial == "b#");
  CHECK(trials[1].name() == file.string() + "#b#");
  CHECK(trials[2].name() == none.string());
  CHECK(trials[2].trial.empty());
  test::check_error([&] { make_sources({file, "-"}, by_run); }, Code::setting_conflict, "trial_column");
  // An error says which trial it is of.
  const auto wrong = test::write_text(folder / "wrong.csv", "run,sway_deg\na,1\na,2\nb,1\nb,x\n");
  ReadOptions options{.recording = by_run, .trial = {}, .truth = {}};
  options.recording.rate_hz = 100.0;
  const std::vector<RecordingResult> read =
      read_recordings(sim::short_protocol(), make_sources({wrong, none}, by_run), options);
  REQUIRE(read.size() == 3);
  REQUIRE(read[1].error);
  CHECK(read[1].error->where() == wrong.string() + "#b");
  REQUIRE(read[2].error);
  CHECK(read[2].error->where() == none.string());
}

}  // namespace decid
