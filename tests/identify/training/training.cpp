// Training is a pure function of its settings: threads, interruption and the kernels in use have no say in the bits.
#include "identify/training/training.hpp"

#include <doctest/doctest.h>
#include <omp.h>

#include <cmath>

#include "base/error.hpp"
#include "base/files/sha256.hpp"
#include "identify/network/prediction.hpp"
#include "identify/training/checkpoint.hpp"
#include "tests/helpers.hpp"

namespace decid::tools {
namespace {

sim::Protocol quick_protocol() {
  sim::Protocol protocol = sim::short_protocol();
  protocol.sequence().cycles = 1;
  protocol.sequence().lead_in_s = protocol.sequence().lead_out_s = 0.0;
  protocol.noise.sensor = {0.001, 0.1};
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
  settings.preset.batch = 20;  // of 35 trials: batches of 18 and 17, no multiples of the 16 lanes
  settings.seed = 5;
  return settings;
}

/// Trains to the end.
bool train(const dataset::TrialSource& source, const TrainingSettings& settings, TrainingState& state) {
  return run_training(
      source, settings, state, [](int, int) { return true; }, [] {});
}

std::string train_hash(const dataset::TrialSource& source) {
  const TrainingSettings settings = quick_settings();
  TrainingState state = start_training(source, settings);
  train(source, settings, state);
  return nn::weights_sha256(state.model.network) + sha256(log_csv(state.log, 7));
}

}  // namespace

TEST_CASE("a batch size that leaves one trial over trains as well as one that leaves none") {
  // BatchNorm behind fc: alone in its batch, a trial would be normalised to beta, whatever it is.
  const auto source = quick_source();  // 35 trials
  TrainingSettings settings = quick_settings();
  settings.preset.architecture = "globalavgpool; fc 16; batchnorm; relu; fc 7";
  settings.preset.epochs = 20;
  const auto validated = [&](int batch) {
    settings.preset.batch = batch;
    TrainingState state = start_training(*source, settings);
    std::vector<int> done;
    CHECK(run_training(
        *source, settings, state,
        [&](int trials, int) {
          done.push_back(trials);
          return true;
        },
        [] {}));
    CHECK(done.front() == (batch == 35 ? 35 : 18));
    return state.log.back().validation_mse;
  };
  const double whole = validated(35), tail = validated(34);
  CAPTURE(whole);
  CAPTURE(tail);
  CHECK(tail < 1.25 * whole);

  settings.preset.batch = 1;
  TrainingState state = start_training(*source, settings);
  const std::string before = nn::weights_sha256(state.model.network);
  test::check_error([&] { train(*source, settings, state); }, Code::setting_out_of_range, "layers.2");
  CHECK(nn::weights_sha256(state.model.network) == before);
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
        const Checkpoint there{"1", state.optimiser.memory.at(0)};
        kept = to_bytes(state.model, &there);
      }));
  Checkpoint checkpoint;
  TrainingState resumed{
      model_from_bytes(kept, "checkpoint", &checkpoint), {state.log.at(0)}, {0, {checkpoint.momentum_buffers}}};
  CHECK(checkpoint.progress == "1");
  CHECK(train(*source, settings, resumed));
  CHECK(nn::weights_sha256(resumed.model.network) + sha256(log_csv(resumed.log, 7)) == straight);

  // The state itself is in the middle of epoch 2, and goes on from there, through a file too.
  CHECK(state.part.trials > 0);
  TrainingState middle = state_from_bytes(checkpoint_bytes(state));
  CHECK(middle.part == state.part);
  CHECK(middle.log == state.log);
  int first = 0;
  CHECK(run_training(
      *source, settings, middle,
      [&](int done, int) {
        if (first == 0) first = done;
        return true;
      },
      [] {}));
  CHECK(first > state.part.trials);
  CHECK(nn::weights_sha256(middle.model.network) + sha256(log_csv(middle.log, 7)) == straight);
}

TEST_CASE("a moving average: that of the weights and statistics after each step, beside the same training") {
  const auto source = quick_source();
  const std::string plain = train_hash(*source);
  TrainingSettings settings = quick_settings();
  settings.average = 0.6;
  TrainingState state = start_training(*source, settings);
  // The reference in double, for weights and statistics one after the other.
  const auto values_of = [](const nn::Network<float>& network) {
    std::vector<double> all;
    for (const nn::Layer<float>& layer : network.layers()) {
      for (const auto& p : layer.parameters()) all.insert(all.end(), p.value.begin(), p.value.end());
      for (const auto& s : layer.statistics()) all.insert(all.end(), s.value.begin(), s.value.end());
    }
    return all;
  };
  std::vector<double> expected = values_of(state.model.network);
  double step = 0;
  CHECK(run_training(
      *source, settings, state,
      [&](int, int) {
        ++step;
        const double decay = std::min(0.6, (1 + step) / (10 + step));
        const std::vector<double> now = values_of(state.model.network);
        for (std::size_t i = 0; i < now.size(); ++i) expected[i] += (1 - decay) * (now[i] - expected[i]);
        return true;
      },
      [] {}));
  CHECK(step == 6);
  REQUIRE(state.average);
  const std::vector<double> average = values_of(*state.average);
  REQUIRE(average.size() == expected.size());
  double worst = 0;  // roundings of six steps in float
  for (std::size_t i = 0; i < average.size(); ++i)
    worst = std::max(worst, std::abs(average[i] - expected[i]) / (1e-3 + std::abs(expected[i])));
  CHECK(worst < 1e-5);
  // The weights that are trained have the bits of a training without an average; the model has the average.
  TrainingSettings without = settings;
  without.average = 0;
  TrainingState other = start_training(*source, without);
  train(*source, without, other);
  CHECK(nn::weights_sha256(other.model.network) == nn::weights_sha256(state.model.network));
  CHECK_FALSE(other.average);
  CHECK(nn::weights_sha256(trained_model(other).network) == nn::weights_sha256(other.model.network));
  const Model model = trained_model(state);
  CHECK(nn::weights_sha256(model.network) == nn::weights_sha256(*state.average));
  const auto predicted = predict(model, *source, dataset::Part::validation, nullptr);
  CHECK(state.log.back().validation_mse == evaluate(model.targets, predicted.scores, predicted.truth).mse());
  CHECK(state.log.back().training_mse == other.log.back().training_mse);
  CHECK(state.log.back().validation_mse != other.log.back().validation_mse);
}

TEST_CASE("a moving average: the same bits for any number of threads, stopped anywhere or not") {
  const auto source = quick_source();
  TrainingSettings settings = quick_settings();
  settings.average = 0.6;
  const auto trained_hash = [](const TrainingState& state) {
    return nn::weights_sha256(trained_model(state).network) + sha256(log_csv(state.log, 7));
  };
  const int threads = omp_get_max_threads();
  std::string straight;
  for (const int count : {1, 3, 8}) {
    omp_set_num_threads(count);
    TrainingState state = start_training(*source, settings);
    train(*source, settings, state);
    if (straight.empty()) straight = trained_hash(state);
    CHECK(trained_hash(state) == straight);
  }
  omp_set_num_threads(threads);
  // Stopped before it has begun, in the middle of an epoch and at an epoch's end, each time through the bytes of a
  // checkpoint.
  for (const int stop : {0, 1, 2, 3}) {
    TrainingState state = start_training(*source, settings);
    int batches = 0;
    if (stop > 0)
      CHECK_FALSE(run_training(
          *source, settings, state, [&](int, int) { return ++batches < stop; }, [] {}));
    TrainingState resumed = state_from_bytes(checkpoint_bytes(state));
    CHECK(resumed.average.has_value() == (stop > 0));
    CHECK(train(*source, settings, resumed));
    CHECK(trained_hash(resumed) == straight);
  }
  for (const double decay : {1.0, -0.1, std::nan("")}) {
    settings.average = decay;
    TrainingState state = start_training(*source, settings);
    test::check_error([&] { train(*source, settings, state); }, Code::setting_out_of_range, "average");
  }
}

TEST_CASE("a checkpoint is for its own protocol, by any name") {
  const test::TemporaryFolder folder;
  const std::string path = folder / "m.checkpoint";
  const auto source = quick_source();
  const TrainingState state = start_training(*source, quick_settings());
  test::write_text(path, checkpoint_bytes(state));
  const TrainingRequest own{state.model.origin, state.model.image(), state.model.protocol};
  TrainingRequest request = own;
  request.protocol.name = "renamed";
  CHECK(nn::weights_sha256(load_checkpoint(path, request).model.network) == nn::weights_sha256(state.model.network));
  const auto refused = [&] {
    test::check_error([&] { load_checkpoint(path, request); }, Code::file_differs, "another protocol");
  };
  request.protocol.noise.sensor = {0.01, 0.01};
  refused();
  request = own;
  request.protocol.sequence().amplitude_deg = 2.0;
  refused();
}

TEST_CASE("weights of a model of another shape are refused, and so is the middle of an epoch that is none") {
  const auto source = quick_source();
  const TrainingSettings settings = quick_settings();
  const TrainingState own = start_training(*source, settings);
  CHECK(start_training(*source, settings, own.model, "m").model.rows.mean == own.model.rows.mean);
  const auto refused = [&](const TrainingSettings& changed, const char* what) {
    test::check_error([&] { start_training(*source, changed, own.model, "m"); }, Code::file_differs, what);
  };
  TrainingSettings changed = settings;
  changed.preset.architecture = "conv 4 5x5 stride 4x4; relu; fc 7";
  refused(changed, "another architecture");
  changed = settings;
  changed.preset.image.standardize_rows = !changed.preset.image.standardize_rows;
  refused(changed, "another image");
  for (const int trials : {20 + 1, 10'000}) {
    TrainingState state = start_training(*source, settings);
    state.part.trials = trials;
    test::check_error([&] { train(*source, settings, state); }, Code::setting_out_of_range);
  }
}

TEST_CASE("patience ends a training that no longer improves, resumed or not") {
  const auto source = quick_source();
  TrainingSettings settings = quick_settings();
  settings.preset.epochs = 200;
  settings.preset.schedule = "constant";
  settings.patience = 3;
  TrainingState state = start_training(*source, settings);
  const auto run = [&] { return train(*source, settings, state); };
  CHECK(run());
  const int epochs = static_cast<int>(state.log.size());
  CHECK(epochs < 200);
  CHECK(epochs - best_epoch(state.log) == 3);
  for (const EpochLog& e : state.log)
    CHECK(e.validation_mse >= state.log.at(static_cast<std::size_t>(best_epoch(state.log)) - 1).validation_mse);
  CHECK(run());  // nothing is left
  CHECK(static_cast<int>(state.log.size()) == epochs);
  CHECK(best_epoch({}) == 0);
  CHECK(kept_epoch(state.log, 3).epoch == best_epoch(state.log));
  CHECK(kept_epoch(state.log, 0).epoch == epochs);
}

TEST_CASE("the log's errors are those of the trials, training and validation") {
  // Weights that hardly change, and no batch normalisation, which is another in training.
  const auto source = quick_source();
  TrainingSettings settings = quick_settings();
  settings.preset.architecture = "conv 4 5x5 stride 4x4; relu; fc 7";
  settings.preset.learning_rate = 1e-30;
  settings.preset.epochs = 1;
  TrainingState state = start_training(*source, settings);
  train(*source, settings, state);
  const dataset::Dataset data = dataset::generate({.protocol = quick_protocol(), .count = 70, .seed = 11});
  for (const int half : {0, 1}) {
    std::vector<std::span<const float>> sways;
    std::vector<sim::Parameters> truth;
    for (int i = 0; i < data.trials(); ++i)
      if (data.split[static_cast<std::size_t>(i)] == half) {
        sways.push_back(data.trial(i));
        truth.push_back(data.parameters[static_cast<std::size_t>(i)]);
      }
    const std::vector<float> outputs =
        predict(state.model, static_cast<int>(sways.size()), 64,
                sways_in_memory([&](int i) { return sways[static_cast<std::size_t>(i)]; }));
    double sum = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const auto target = state.model.targets.scale(truth[i]);
      for (std::size_t p = 0; p < target.size(); ++p) {
        const double error = static_cast<double>(outputs[i * target.size() + p]) - static_cast<double>(target[p]);
        sum += error * error / static_cast<double>(truth.size() * target.size());
      }
    }
    CAPTURE(half);
    // Other kernels in training: float's roundings of sums of some hundred.
    CHECK(test::near(half == 0 ? state.log[0].training_mse : state.log[0].validation_mse, sum, 1e-5));
  }
}

TEST_CASE("the rate rises during the epochs of warm-up, and follows its schedule from there") {
  const auto source = quick_source();  // 35 trials: two batches an epoch
  TrainingSettings settings = quick_settings();
  settings.preset.epochs = 4;
  settings.preset.warmup_epochs = 2;
  settings.preset.schedule = "constant";
  const double rate = settings.preset.learning_rate;
  const auto rates = [&] {
    TrainingState state = start_training(*source, settings);
    train(*source, settings, state);
    std::vector<double> logged;
    for (const EpochLog& e : state.log) logged.push_back(e.learning_rate);
    return logged;
  };
  // At an epoch's last step.
  CHECK(rates() == std::vector<double>{0.5 * rate, rate, rate, rate});
  settings.preset.warmup_epochs = 0;
  settings.preset.schedule = "step:2:0.5";
  CHECK(rates() == std::vector<double>{rate, rate, 0.5 * rate, 0.5 * rate});
}

TEST_CASE("weights begin as the seed says, and trials come in its order") {
  const auto source = quick_source();
  TrainingSettings settings = quick_settings();
  const auto first_weights = [&](std::uint64_t seed) {
    settings.seed = seed;
    return nn::weights_sha256(start_training(*source, settings).model.network);
  };
  CHECK(first_weights(1) != first_weights(2));
  Model fresh(quick_protocol(), settings.preset.image, settings.preset.architecture);
  fresh.network.initialise(7);
  CHECK(first_weights(7) == nn::weights_sha256(fresh.network));

  // The same weights at first, another order of the trials.
  const auto trained = [&](std::uint64_t order) {
    settings.seed = 5;
    TrainingState state = start_training(*source, settings);
    settings.seed = order;
    train(*source, settings, state);
    return nn::weights_sha256(state.model.network);
  };
  CHECK(trained(5) != trained(6));
}

TEST_CASE("a diverging training is an error") {
  const auto source = quick_source();
  TrainingSettings settings = quick_settings();
  settings.preset.learning_rate = 1e5;
  settings.preset.schedule = "constant";
  TrainingState state = start_training(*source, settings);
  test::check_error([&] { train(*source, settings, state); }, Code::diverged);
}

}  // namespace decid::tools
