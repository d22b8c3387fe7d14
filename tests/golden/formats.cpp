// Reads files of every format as decid 0.2.0 wrote them, and checks their values. A later version adds a folder of its
// own files beside 0.2.0. Never write the files of an earlier version again.
#include "base/files/json_object.hpp"
#include "base/files/sha256.hpp"
#include "dataset/npz/detail/journal.hpp"
#include "dataset/npz/npz.hpp"
#include "identify/identify.hpp"
#include "identify/training/checkpoint.hpp"
#include "nn/safetensors.hpp"
#include "recording/protocol_file.hpp"
#include "recording/recording.hpp"
#include "sim/protocol/protocol_json.hpp"
#include "tests/helpers.hpp"
#include "tools/decid/results/calibrated_trials.hpp"
#include "tools/decid/results/identified.hpp"
#include "tools/report/comparison_page.hpp"

using namespace decid;
using namespace decid::test;

namespace {

std::filesystem::path file(const char* name) {
  return std::filesystem::path(DECID_SOURCE_DIR) / "tests/golden/0.2.0" / name;
}

}  // namespace

TEST_CASE("models and checkpoints of 0.2.0") {
  const Model model = load_model(file("net.safetensors"));
  CHECK(nn::weights_sha256(model.network) == "d18fe7286289003d9335a7e243455a5ec2167b46e63f24d890d2b7a21e314ae8");
  CHECK(model.head->name() == "mixture 1");
  CHECK(model.protocol.samples() == 80);
  CHECK(model.log.size() == 1);
  CHECK(load_model(file("point.safetensors")).head->name() == "point");
  Checkpoint checkpoint;
  const Model unfinished = model_from_bytes(read_text(file("training.checkpoint")), "checkpoint", &checkpoint);
  CHECK(unfinished.head->name() == "point");
  CHECK_FALSE(checkpoint.progress.empty());
  CHECK(checkpoint.momentum_buffers.size() == 2);
}

TEST_CASE("data sets and their journals of 0.2.0") {
  const dataset::Dataset data = dataset::read_npz(file("data.npz"));
  REQUIRE(data.trials() == 3);
  CHECK(data.samples == 80);
  CHECK(data.seed == 1);
  CHECK(data.protocol.name == "tiny");
  const std::string_view sway(reinterpret_cast<const char*>(data.sway.data()), data.sway.size() * sizeof(float));
  CHECK(sha256(sway) == "96a109052dc73ccc72e8f6ff293002e6d3ce62827789c27a67e18189349cc08f");
  const TemporaryFolder folder;
  dataset::ChunkJournal journal(write_text(folder / "journal", read_text(file("dataset.journal"))));
  REQUIRE(journal.request() == "{\"seed\": 1}");
  const auto first = journal.next(0);
  REQUIRE(first);
  REQUIRE(first->chunk.trials.size() == 2);
  CHECK(first->chunk.trials[1].parameters[6] == 6.0);
  CHECK(first->chunk.trials[1].peak_to_peak_rad == 7.0);
}

TEST_CASE("protocols and recordings of 0.2.0") {
  const sim::Protocol protocol = recording::load_protocol(file("protocol.json").string());
  CHECK(protocol.samples() == 80);
  CHECK(sim::to_json(protocol) == sim::to_json(dataset::read_npz(file("data.npz")).protocol));
  const recording::Recording recording = recording::read_recording(file("trial.csv"), {});
  CHECK(recording.rate_hz == 20.0);
  CHECK(recording.signals.samples() == 80);
}

TEST_CASE("results, calibrations and comparisons of 0.2.0") {
  const tools::Identified found = tools::identified(file("result.json").string(), 1, true);
  CHECK(near(found.parameters[0], 1125.196697264139, 1e-12));
  CHECK_FALSE(found.body);  // nobody gave it
  const Json calibration = parse_json(read_text(file("calibration.json")), "calibration");
  const auto trials = tools::earlier_trials(file("calibration.json").string(), calibration.at("settings"),
                                            calibration.value("network", Json(nullptr)), 7);
  REQUIRE(trials.size() == 2);
  CHECK(trials[0].truth.size() == 7);
  CHECK(trials[0].network.has_value());
  const ComparisonFigures comparison =
      tools::read_comparison(file("comparison.json").string(), sim::default_protocol());
  CHECK(comparison.methods.size() >= 3);
}
