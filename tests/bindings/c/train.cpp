// Training through C: the library's weights, progress callbacks, and stopping.
#include <cmath>

#include "identify/training/checkpoint.hpp"
#include "identify/training/training.hpp"
#include "tests/bindings/c/owned.hpp"

namespace decid {
namespace {

using namespace test;

constexpr const char* tiny_network = "conv 4 7x1 stride 4x1; batchnorm; relu; globalavgpool; fc 7";

decid_train_options tiny() {
  decid_train_options options;
  decid_train_defaults(&options, sizeof options);
  options.architecture = tiny_network;
  options.epochs = 2;
  options.batch = 20;
  options.learning_rate = 0.02;
  options.momentum = 0.5;
  options.seed = 3;
  options.stream_trials = 60;
  options.validation_trials = 20;
  return options;
}

/// Trains with the steps of `decid train` and the same settings.
std::string expected_sha256(const dataset::TrialSource& source, int scaling_trials) {
  TrainingSettings settings;
  settings.preset = preset_named("best");
  settings.preset.architecture = tiny_network;
  settings.preset.epochs = 2;
  settings.preset.batch = 20;
  settings.preset.learning_rate = 0.02;
  settings.preset.sgd.momentum = 0.5;
  settings.preset.image = image_for(settings.preset, source.protocol());
  settings.seed = 3;
  settings.scaling_trials = scaling_trials;
  TrainingState state = start_training(source, settings);
  run_training(
      source, settings, state, [](int, int) { return true; }, [] {});
  return nn::weights_sha256(state.model.network);
}

OwnedModel train(const decid_dataset* dataset, const decid_protocol* protocol, const decid_train_options& options) {
  return make<OwnedModel>([&](decid_model** place) { return decid_train(dataset, protocol, &options, place); });
}

}  // namespace

TEST_CASE("training has the weights of the library's, on new trials and on a data set") {
  const OwnedProtocol played = protocol("default");
  std::vector<decid_training> reported;
  decid_train_options options = tiny();
  options.user = &reported;
  options.progress = [](void* user, const decid_training* training) {
    static_cast<std::vector<decid_training>*>(user)->push_back(*training);
    return 0;
  };
  const OwnedModel streamed = train(nullptr, played.get(), options);
  CHECK(decid_model_sha256(streamed.get()) ==
        expected_sha256(*dataset::stream_source(sim::default_protocol(), 3, 60, 20), 2000));
  REQUIRE(reported.size() == 2 * (3 + 1));
  for (std::size_t i = 0; i < reported.size(); ++i) {
    CHECK(reported[i].epoch == static_cast<int>(i / 4) + 1);
    CHECK(reported[i].epochs == 2);
    CHECK(reported[i].trials == 60);
    CHECK(reported[i].done == std::min(20 * (static_cast<int>(i % 4) + 1), 60));
    CHECK(reported[i].epoch_is_over == (i % 4 == 3 ? 1 : 0));
    CHECK(std::isnan(reported[i].validation_mse) == (i % 4 != 3));
  }

  decid_dataset_options wanted;
  decid_dataset_defaults(&wanted, sizeof wanted);
  wanted.count = 40;
  wanted.seed = 5;
  const OwnedDataset data =
      make<OwnedDataset>([&](decid_dataset** place) { return decid_dataset_make(played.get(), &wanted, place); });
  const OwnedModel trained = train(data.get(), nullptr, tiny());
  const dataset::Dataset same = dataset::generate({.protocol = sim::default_protocol(), .count = 40, .seed = 5});
  CHECK(decid_model_sha256(trained.get()) == expected_sha256(*dataset::stored_source(dataset::StoredDataset(same)), 0));
  // It knows what it was trained on.
  decid_evaluation found;
  refused(decid_evaluate(trained.get(), data.get(), DECID_ALL, &found, sizeof found), Code::data_reused);
  CHECK(decid_evaluate(trained.get(), data.get(), DECID_VALIDATION, &found, sizeof found) == DECID_OK);
}

TEST_CASE("with patience the best epoch's model is kept") {
  const OwnedProtocol played = protocol("default");
  decid_train_options options = tiny();
  options.epochs = 30;
  options.learning_rate = 0.5;  // overshoots
  options.patience = 1;
  options.schedule = "constant";  // the same number of epochs gives the same weights
  std::vector<double> errors;
  options.user = &errors;
  options.progress = [](void* user, const decid_training* training) {
    if (training->epoch_is_over != 0) static_cast<std::vector<double>*>(user)->push_back(training->validation_mse);
    return 0;
  };
  const OwnedModel model = train(nullptr, played.get(), options);
  REQUIRE(errors.size() >= 2);
  REQUIRE(errors.size() < 30);
  CHECK(errors[errors.size() - 1] >= errors[errors.size() - 2]);
  decid_train_options shorter = options;
  shorter.patience = 0;
  shorter.epochs = static_cast<int>(errors.size()) - 1;
  shorter.progress = nullptr;
  const OwnedModel best = train(nullptr, played.get(), shorter);
  CHECK(std::string(decid_model_sha256(model.get())) == decid_model_sha256(best.get()));
}

TEST_CASE("a callback stops a training after a batch or an epoch") {
  const OwnedProtocol played = protocol("default");
  decid_train_options options = tiny();
  options.progress = [](void*, const decid_training* training) { return training->done == 40 ? 1 : 0; };
  decid_model* model = nullptr;
  refused(decid_train(nullptr, played.get(), &options, &model), Code::stopped, "decid_train");
  options.progress = [](void*, const decid_training* training) { return training->epoch_is_over; };
  refused(decid_train(nullptr, played.get(), &options, &model), Code::stopped, "decid_train");
  CHECK(model == nullptr);
}

TEST_CASE("training refuses settings that decid train refuses") {
  const OwnedProtocol played = protocol("default");
  decid_model* model = nullptr;
  const auto refuse = [&](auto change, Code code, std::string_view fact = {}) {
    decid_train_options options = tiny();
    change(options);
    refused(decid_train(nullptr, played.get(), &options, &model), code, fact);
  };
  refuse([](auto& options) { options.preset = "no"; }, Code::setting_unknown);
  refuse([](auto& options) { options.architecture = "conv"; }, Code::setting_malformed);
  refuse([](auto& options) { options.head = "no"; }, Code::file_unsupported);
  refuse([](auto& options) { options.schedule = "no"; }, Code::setting_malformed);
  refuse([](auto& options) { options.image = "{"; }, Code::setting_malformed);
  refuse([](auto& options) { options.epochs = -1; }, Code::setting_out_of_range, "epochs is -1");
  refuse([](auto& options) { options.batch = 5000; }, Code::setting_out_of_range);
  refuse([](auto& options) { options.learning_rate = -0.1; }, Code::setting_out_of_range, "learning_rate");
  refuse([](auto& options) { options.momentum = 1.0; }, Code::setting_out_of_range);
  refuse([](auto& options) { options.weight_decay = 2.0; }, Code::setting_out_of_range, "weight_decay");
  refuse([](auto& options) { options.patience = -1; }, Code::setting_out_of_range);
  refuse([](auto& options) { options.stream_trials = 0; }, Code::setting_out_of_range);
  for (const int trials : {15, 100'000'001})
    refuse([=](auto& options) { options.stream_trials = trials; }, Code::setting_out_of_range,
           "stream_trials is " + std::to_string(trials));
  for (const int trials : {0, 1'000'001})
    refuse([=](auto& options) { options.validation_trials = trials; }, Code::setting_out_of_range, "validation_trials");
  // Without a preset it is the default one, whose other settings are checked next.
  refuse([](auto& options) { options.preset = nullptr, options.momentum = 1.0; }, Code::setting_out_of_range,
         "momentum is 1");
  decid_train_options options = tiny();
  refused(decid_train(nullptr, nullptr, &options, &model), Code::setting_missing);
  CHECK(model == nullptr);
}

}  // namespace decid
