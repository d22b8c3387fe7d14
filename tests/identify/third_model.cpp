// A program's own model of body and controller, from a data set to an identified trial, without a change of the
// library.

#include "tests/sim/third_model.hpp"

#include "base/error.hpp"
#include "dataset/npz/npz.hpp"
#include "identify/identify.hpp"
#include "identify/training/training.hpp"
#include "sim/protocol/protocol_json.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"

namespace decid {
namespace {

using namespace test;

sim::Protocol quick_protocol() {
  sim::register_body_model(third_model());
  sim::Protocol protocol = sim::short_protocol();
  protocol.sequence().cycles = 1;
  protocol.sequence().lead_in_s = protocol.sequence().lead_out_s = 0.0;
  protocol.experiment.body_model = &third_model();
  return protocol;
}

}  // namespace

TEST_CASE("a model of body and controller that the library does not have: data set, training, identification") {
  const TemporaryFolder folder;
  dataset::DatasetRequest request;
  request.protocol = quick_protocol();
  request.count = 400;
  request.seed = 3;
  const std::string file = (folder / "d.npz").string();
  dataset::generate_npz(file, request, "a test", [](int, int) { return true; });
  const dataset::StoredDataset stored(file);
  const sim::BodyModel& model_of_file = *stored.about().protocol.experiment.body_model;
  CHECK(&model_of_file == &third_model());

  const auto source = dataset::stored_source(stored);
  TrainingSettings settings;
  settings.preset = with_head(preset_named("small"), "mixture 1", third_model().parameters.size(), "test");
  settings.preset.epochs = 12;
  settings.head = &head_named(settings.preset.head, "test");
  settings.seed = 5;
  TrainingState state = start_training(*source, settings);
  run_training(
      *source, settings, state, [](int, int) { return true; }, [] {});
  CHECK(state.log.back().validation_mse < 0.98);  // guessing the mean gives 1
  const Model model = model_from_bytes(to_bytes(state.model), "third.safetensors");
  CHECK(model.protocol.experiment.body_model == &third_model());

  const sim::Simulator simulator(request.protocol);
  std::vector<double> sway(static_cast<std::size_t>(simulator.samples()));
  REQUIRE(simulator.run(third_model().parameters.middle(), Random(9, sim::streams::vestibular_noise, 0), sway).valid);
  RecordingResult result;
  result.trial = recording::make_trial({sway.begin(), sway.end()});
  std::vector<RecordingResult> results{std::move(result)};
  Identifier identifier(model);
  identifier.identify(results);
  const sim::Parameters& found = results.front().estimate.parameters;
  REQUIRE(found.size() == third_model().parameters.size());
  for (std::size_t p = 0; p < found.size(); ++p) {
    CAPTURE(third_model().parameters[p].name);
    CHECK(!third_model().parameters[p].is_beyond(found[p]));
  }
  CHECK(results.front().explanation.fitted_rad.size() == sway.size());
}

}  // namespace decid
