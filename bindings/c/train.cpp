// Training in C: the steps of `decid train`, its files left out.
#include <limits>

#include "base/version.hpp"
#include "bindings/c/handles.hpp"
#include "identify/training/checkpoint.hpp"
#include "identify/training/training.hpp"
#include "nn/training/schedule.hpp"

using namespace decid::c;

namespace {

constexpr const char* default_preset = "best";

// The ranges are those of decid train.
template <class Value>
void require(Value value, Value low, Value high, const char* field, const char* remedy) {
  if (value >= low && value <= high) return;
  throw decid::Error(decid::Code::setting_out_of_range, "decid_train",
                     decid::format("%s is %.10g", field, static_cast<double>(value)), remedy);
}

void require_stream(const decid_train_options& asked) {
  require(asked.stream_trials, 16, 100'000'000, "stream_trials", "give 16 to 100,000,000");
  require(asked.validation_trials, 1, 1'000'000, "validation_trials", "give 1 to 1,000,000");
}

decid::TrainingSettings settings_of(const decid_train_options& asked, const decid::dataset::TrialSource& source,
                                    bool stream) {
  decid::TrainingSettings settings;
  decid::Preset& preset = settings.preset =
      decid::preset_named(asked.preset == nullptr ? default_preset : asked.preset);
  if (asked.head != nullptr) preset.head = asked.head;
  preset = decid::with_head(preset, preset.head, source.protocol().parameters().size(), "head");
  if (asked.architecture != nullptr) preset.architecture = asked.architecture;
  if (asked.schedule != nullptr) preset.schedule = asked.schedule;
  if (asked.epochs != 0) preset.epochs = asked.epochs;
  if (asked.batch != 0) preset.batch = asked.batch;
  if (asked.learning_rate != 0.0) preset.learning_rate = asked.learning_rate;
  if (asked.momentum != -1.0) preset.sgd.momentum = asked.momentum;
  if (asked.weight_decay != -1.0) preset.sgd.weight_decay = asked.weight_decay;
  require(preset.epochs, 1, 1'000'000, "epochs", "give 1 to 1,000,000");
  require(preset.batch, 1, 4096, "batch", "give 1 to 4096 samples a step");
  require(preset.learning_rate, 1e-12, 1e3, "learning_rate", "give 1e-12 to 1000");
  require(preset.sgd.momentum, 0.0, 0.9999, "momentum", "give 0 to 0.9999");
  require(preset.sgd.weight_decay, 0.0, 1.0, "weight_decay", "give 0 to 1");
  require(asked.patience, 0, std::numeric_limits<int>::max(), "patience", "give 0 for never, or a number of epochs");
  decid::nn::Schedule(preset.schedule, preset.learning_rate, 1, 1);  // throws for a wrong schedule before the work
  preset.image = asked.image != nullptr ? decid::dataset::image_settings_from_json(asked.image, "image")
                                        : decid::image_for(preset, source.protocol());
  settings.head = &decid::chosen_head(preset.head, "head");
  settings.seed = asked.seed;
  settings.patience = asked.patience;
  settings.scaling_trials = stream ? 2000 : 0;
  return settings;
}

/// Reports progress to a callback, and stops the training if the callback asks for it.
class Teller {
 public:
  Teller(const decid_train_options& asked, int epochs, int trials) : asked_(asked) {
    training_ = {1, epochs, 0, trials, 0, unknown, unknown, unknown};
  }

  bool after_batch(int done) {
    training_.epoch += training_.epoch_is_over;
    training_.epoch_is_over = 0;
    training_.done = done;
    training_.training_mse = training_.validation_mse = training_.learning_rate = unknown;
    return tell();
  }
  void after_epoch(const decid::EpochLog& log) {
    training_.epoch_is_over = 1;
    training_.training_mse = log.training_mse;
    training_.validation_mse = log.validation_mse;
    training_.learning_rate = log.learning_rate;
    if (!tell()) throw Stopped{"decid_train"};
  }

 private:
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  bool tell() const { return asked_.progress == nullptr || asked_.progress(asked_.user, &training_) == 0; }

  const decid_train_options& asked_;
  decid_training training_;
};

decid::Model train(const decid::dataset::TrialSource& source, const decid_train_options& asked, bool stream) {
  const decid::TrainingSettings settings = settings_of(asked, source, stream);
  decid::TrainingState state = decid::start_training(source, settings);
  state.model.origin = decid::make_origin(settings, source, std::string("decid ") + decid::version);
  Teller teller(asked, settings.preset.epochs, source.trials(decid::dataset::Part::training));
  std::string best;  // the model of the best epoch so far
  const bool finished = decid::run_training(
      source, settings, state, [&](int done, int) { return teller.after_batch(done); },
      [&] {
        if (settings.patience > 0 && decid::best_epoch(state.log) == state.log.back().epoch)
          best = decid::to_bytes(state.model);
        teller.after_epoch(state.log.back());
      });
  if (!finished) throw Stopped{"decid_train"};
  if (!best.empty()) state.model = decid::model_from_bytes(best, "the best epoch's model");
  state.model.log = std::move(state.log);
  state.model.ood_detector = decid::learn_ood_detector(state.model, source, settings.preset.epochs);
  state.model.recalibration = decid::learn_recalibration(state.model, source, settings.preset.epochs);
  return std::move(state.model);
}

}  // namespace

void decid_train_defaults(decid_train_options* options, size_t size) {
  decid_train_options defaults{};
  defaults.preset = default_preset;
  defaults.momentum = defaults.weight_decay = -1.0;
  defaults.seed = 1;
  defaults.stream_trials = 25600;
  defaults.validation_trials = 1000;
  set_defaults(options, size, defaults);
}

decid_status decid_train(const decid_dataset* dataset, const decid_protocol* protocol,
                         const decid_train_options* options, decid_model** model) {
  constexpr const char* where = "decid_train";
  return made(model, where, [&] {
    const decid_train_options asked = options_of(options, decid_train_defaults, where);
    if ((dataset == nullptr) == (protocol == nullptr))
      throw decid::Error(decid::Code::setting_missing, where, "needs trials",
                         "give a data set or a protocol, one of the two");
    const bool stream = protocol != nullptr;
    if (stream) require_stream(asked);
    const auto source = stream ? decid::dataset::stream_source(protocol->protocol(), asked.seed, asked.stream_trials,
                                                               asked.validation_trials)
                               : decid::dataset::stored_source(dataset->data);
    return std::make_unique<decid_model>(train(*source, asked, stream), "the trained model");
  });
}
