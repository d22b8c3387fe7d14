// Training is a pure function of its settings: threads, interruption and the kernels in use have no say in the bits.
#include "identify/training/training.hpp"

#include <doctest/doctest.h>
#include <omp.h>

#include <cmath>

#include "base/error.hpp"
#include "base/sha256.hpp"

namespace decid::tools {
namespace {

sim::Protocol quick_protocol() {
  sim::Protocol protocol = sim::short_protocol();
  protocol.sequence().cycles = 1;
  protocol.sequence().lead_in_s = protocol.sequence().lead_out_s = 0.0;
  protocol.sensor_noise = {0.001, 0.1};
  return protocol;
}

std::unique_ptr<dataset::TrialSource> quick_source() {
  dataset::DatasetRequest request;
  request.protocol = quick_protocol();
  request.count = 70;
  request.seed = 11;
  return dataset::stored_source(dataset::generate(request));
}

TrainingSettings quick_settings() {
  TrainingSettings settings;
  settings.preset = preset_named("small");
  settings.preset.epochs = 3;
  settings.preset.batch = 20;  // no multiple of the 16 lanes, and the last batch is smaller still
  settings.seed = 5;
  return settings;
}

std::string train_hash(const dataset::TrialSource& source) {
  const TrainingSettings settings = quick_settings();
  TrainingState state = start_training(source, settings);
  run_training(
      source, settings, state, [](int, int) { return true; }, [] {});
  return nn::weights_sha256(state.model.network) + sha256(log_csv(state.log));
}

}  // namespace

TEST_CASE("weights and log are the same for any number of threads") {
  const auto source = quick_source();
  const int before = omp_get_max_threads();
  omp_set_num_threads(1);
  const std::string once = train_hash(*source);
  for (const int threads : {2, 3, 8}) {
    omp_set_num_threads(threads);
    CAPTURE(threads);
    CHECK(train_hash(*source) == once);
    CHECK(train_hash(*quick_source()) == once);  // the data set too
  }
  omp_set_num_threads(before);
}

TEST_CASE("a training on streamed trials") {
  const auto source = dataset::stream_source(quick_protocol(), 3, 60, 20);
  TrainingSettings settings = quick_settings();
  settings.scaling_trials = 30;
  TrainingState state = start_training(*source, settings);
  CHECK(run_training(
      *source, settings, state, [](int, int) { return true; }, [] {}));
  REQUIRE(state.log.size() == 3);
  CHECK(std::isfinite(state.log.back().validation_mse));
}

TEST_CASE("a training that is stopped and goes on ends in the same bits") {
  const auto source = quick_source();
  const std::string straight = train_hash(*source);
  const TrainingSettings settings = quick_settings();
  TrainingState state = start_training(*source, settings);
  std::string kept;
  int batches = 0;
  // Stops in the middle of epoch 2; what was kept is the end of epoch 1.
  CHECK_FALSE(run_training(
      *source, settings, state, [&](int, int) { return ++batches < 3; },
      [&] {
        const Checkpoint there{"1", state.velocities};
        kept = to_bytes(state.model, &there);
      }));
  Checkpoint checkpoint;
  TrainingState resumed{model_from_bytes(kept, "checkpoint", &checkpoint), {state.log.at(0)}, checkpoint.velocities};
  CHECK(checkpoint.progress == "1");
  CHECK(run_training(
      *source, settings, resumed, [](int, int) { return true; }, [] {}));
  CHECK(nn::weights_sha256(resumed.model.network) + sha256(log_csv(resumed.log)) == straight);
}

TEST_CASE("patience ends a training that no longer improves, resumed or not") {
  const auto source = quick_source();
  TrainingSettings settings = quick_settings();
  settings.preset.epochs = 200;
  settings.preset.schedule = "constant";
  settings.patience = 3;
  TrainingState state = start_training(*source, settings);
  const auto run = [&] {
    return run_training(
        *source, settings, state, [](int, int) { return true; }, [] {});
  };
  CHECK(run());
  const int epochs = static_cast<int>(state.log.size());
  CHECK(epochs < 200);
  CHECK(epochs - best_epoch(state.log) == 3);
  for (const EpochLog& e : state.log)
    CHECK(e.validation_mse >= state.log.at(static_cast<std::size_t>(best_epoch(state.log)) - 1).validation_mse);
  CHECK(run());  // nothing is left
  CHECK(static_cast<int>(state.log.size()) == epochs);
  CHECK(best_epoch({}) == 0);
}

TEST_CASE("a training that diverges says so") {
  const auto source = quick_source();
  TrainingSettings settings = quick_settings();
  settings.preset.learning_rate = 1e5;
  settings.preset.schedule = "constant";
  TrainingState state = start_training(*source, settings);
  CHECK_THROWS_WITH_AS(run_training(
                           *source, settings, state, [](int, int) { return true; }, [] {}),
                       doctest::Contains("lower --lr"), Error);
}

TEST_CASE("learning from few trials goes below the error of the mean") {
  const auto source = quick_source();
  TrainingSettings settings = quick_settings();
  settings.preset.epochs = 25;
  TrainingState state = start_training(*source, settings);
  run_training(
      *source, settings, state, [](int, int) { return true; }, [] {});
  CHECK(state.log.back().training_mse < 0.7);
  CHECK(state.log.front().training_mse > state.log.back().training_mse);
}

}  // namespace decid::tools
