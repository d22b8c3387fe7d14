// The training loop: see training.hpp.
#include "identify/training/training.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "base/setting.hpp"
#include "base/text.hpp"
#include "dataset/feed.hpp"
#include "identify/network/prediction.hpp"
#include "identify/training/checkpoint.hpp"
#include "nn/safetensors.hpp"
#include "nn/training/average.hpp"
#include "nn/training/batch_partition.hpp"
#include "nn/training/loop.hpp"
#include "nn/training/schedule.hpp"
#include "nn/training/trainer.hpp"

namespace decid {
namespace {

/// Throws Error, before the work, for a decay that move_average() would refuse.
void check_average(double decay) {
  if (!(decay >= 0 && decay < 1))
    throw Error(Code::setting_out_of_range, setting("average"), format("has a decay of %g", decay),
                "give 0 for none, or a number below 1, for example 0.999");
}

double validate(const dataset::TrialSource& source, const Model& model, Communicator* ranks) {
  const Predicted predicted = predict(model, source, dataset::Part::validation, ranks);
  return evaluate(model.targets, predicted.scores, predicted.truth).mse();
}

/// Puts together what all ranks have of a batch's loss.
class SharedLoss {
 public:
  SharedLoss(Communicator& ranks, const Head& head, std::size_t parameters)
      : ranks_(ranks), head_(head), parameters_(parameters), width_(head.loss_parts(parameters)) {}

  /// The loss of the whole batch. stop: this rank requests a stop; asked() returns true if any rank does.
  double of(nn::Trainer<float>& trainer, const dataset::Feed::Batch& batch, bool stop) {
    const nn::BatchPartition& batch_partition = partition(batch.trials);
    own_.assign(batch_partition.blocks.size() * width_ + 1, 0.0);
    head_.loss(trainer.output(), batch.targets, batch.trials, parameters_, std::span(own_).subspan(1),
               trainer.output_diff());
    own_.front() = stop ? 1.0 : 0.0;
    std::vector<std::size_t> place, sizes;  // of each rank's next value, and of all its bytes
    std::size_t count = 0;
    for (int rank = 0; rank < ranks_.size(); ++rank) {
      place.push_back(count + 1);
      const auto blocks = static_cast<std::size_t>(std::ranges::count(batch_partition.owner, rank));
      count += blocks * width_ + 1;
      sizes.push_back((blocks * width_ + 1) * sizeof(double));
    }
    all_.resize(count);
    ranks_.all_gather(std::as_bytes(std::span(own_)), sizes, std::as_writable_bytes(std::span(all_)));
    asked_ = std::ranges::any_of(place, [&](std::size_t first) { return all_[first - 1] != 0.0; });
    parts_.clear();
    for (const int owner : batch_partition.owner) {
      std::size_t& first = place[static_cast<std::size_t>(owner)];
      for (std::size_t i = 0; i < width_; ++i) parts_.push_back(all_[first++]);
    }
    return head_.total_loss(parts_, parameters_);
  }
  bool asked() const { return asked_; }

 private:
  const nn::BatchPartition& partition(int batch) {
    const auto [found, is_new] = partitions_.try_emplace(batch);
    if (is_new)
      found->second = nn::make_partition(static_cast<int>(nn::TensorView<float>::count_blocks(batch)), ranks_.rank(),
                                         ranks_.size());
    return found->second;
  }

  Communicator& ranks_;
  const Head& head_;
  std::size_t parameters_, width_;
  std::vector<double> own_, all_, parts_;
  std::map<int, nn::BatchPartition> partitions_;
  bool asked_ = false;
};

/// Lines joined by semicolons, as an architecture may be written too.
std::string in_a_line(const std::string& text) {
  std::string line;
  for (const char c : text) line += c == '\n' ? "; " : std::string(1, c);
  return line;
}

Diverged diverged(const Preset& preset, int epoch, const std::string& how) {
  return Diverged(Code::diverged, "training", format("diverged in epoch %d of %d: ", epoch, preset.epochs) + how,
                  format("lower the learning rate of %g (%s)", preset.learning_rate, setting("learning_rate").c_str()));
}

}  // namespace

double Evaluation::mse() const {
  return std::accumulate(mse_per_parameter.begin(), mse_per_parameter.end(), 0.0) /
         static_cast<double>(mse_per_parameter.size());
}

Evaluation evaluate(const dataset::TargetScaling& targets, std::span<const float> scores,
                    std::span<const sim::Parameters> truth) {
  const std::size_t parameters = targets.mean.size();
  Evaluation result;
  result.mse_per_parameter.resize(parameters);
  result.trials = static_cast<int>(truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const std::vector<float> target = targets.scale(truth[i]);
    for (std::size_t p = 0; p < parameters; ++p) {
      const double error = static_cast<double>(scores[i * parameters + p]) - static_cast<double>(target[p]);
      result.mse_per_parameter[p] += error * error;
    }
  }
  for (double& mse : result.mse_per_parameter) mse /= static_cast<double>(truth.size());
  return result;
}

TrainingState start_training(const dataset::TrialSource& source, const TrainingSettings& settings) {
  TrainingState state{Model(source.protocol(), settings.preset.image, settings.preset.architecture, *settings.head),
                      {}};
  const int all = source.trials(dataset::Part::training);
  dataset::Scaling scaling = dataset::measure_scaling(source, state.model.images(),
                                                      settings.scaling_trials > 0 ? settings.scaling_trials : all);
  state.model.rows = std::move(scaling.rows);
  state.model.targets = settings.head->scaling(state.model.parameters(), scaling.targets);
  state.model.network.initialise(settings.seed);
  for (nn::Parameter<float>& parameter : state.model.network.layers().back().parameters())
    for (float& value : parameter.value) value *= settings.head->first_weights();
  return state;
}

TrainingState start_training(const dataset::TrialSource& source, const TrainingSettings& settings, const Model& from,
                             const std::string& name) {
  TrainingState state{Model(source.protocol(), settings.preset.image, settings.preset.architecture, *settings.head),
                      {}};
  Model& model = state.model;
  const auto refuse = [&](const std::string& what, const std::string& there, const std::string& here) {
    const std::string& preset = from.origin.preset;
    throw Error(
        Code::file_differs, name,
        "has another " + what + " than this training: " + in_a_line(there) + " there, " + in_a_line(here) + " here",
        "give " + (preset.empty() ? "" : setting("preset") + " " + preset + ", with which it was trained, or ") +
            "its " + setting("architecture") + ", " + setting("head") + " and " + setting("image") +
            ", as decid info shows them");
  };
  if (from.network.architecture() != model.network.architecture())
    refuse("architecture", from.network.architecture(), model.network.architecture());
  if (from.head != model.head) refuse("head", from.head->name(), model.head->name());
  if (from.image() != model.image() || from.network.input_shape() != model.network.input_shape())
    refuse("image", dataset::to_json(from.image()), dataset::to_json(model.image()));
  if (from.parameters().size() != model.parameters().size())
    refuse("body model", counted(static_cast<long long>(from.parameters().size()), "parameter"),
           counted(static_cast<long long>(model.parameters().size()), "parameter"));
  model.rows = from.rows;
  model.targets = from.targets;
  model.network = from.network;
  return state;
}

Model trained_model(const TrainingState& state) {
  Model model = state.model;
  if (state.average) model.network = *state.average;
  return model;
}

void share_state(Communicator& ranks, std::optional<TrainingState>& state) {
  const std::string bytes = broadcast_text(&ranks, ranks.is_root() ? checkpoint_bytes(*state) : std::string());
  if (!ranks.is_root()) state = state_from_bytes(bytes);
}

namespace {

/// decid's training as parts of nn::run(): trials from a feed, the model's head, batches shared with other ranks.
class ModelTraining final : public nn::TrainingLoop {
 public:
  using AfterBatch = std::function<bool(int, int)>;

  ModelTraining(const dataset::TrialSource& source, const TrainingSettings& settings, TrainingState& state,
                const AfterBatch& after_batch, const std::function<void()>& after_epoch)
      : source_(source),
        settings_(settings),
        preset_(settings.preset),
        state_(state),
        model_(state.model),
        after_batch_(after_batch),
        after_epoch_(after_epoch),
        trials_(source.trials(dataset::Part::training)),
        batches_(trials_, preset_.batch),
        schedule_(preset_.schedule, preset_.learning_rate, 1LL * batches_.count() * preset_.epochs, batches_.count(),
                  1LL * batches_.count() * preset_.warmup_epochs),
        optimiser_(nn::sgd(preset_.sgd)),
        trainer_(model_.network, batches_.size(0), settings.ranks) {
    trainer_.set_batch(batches_.min_size());  // throws before the first step, not at the epoch's end
    check_average(settings.average);
    if (settings.average > 0 && !state.average) state.average = model_.network;
    dataset::BatchSharing sharing;
    if (settings.ranks != nullptr) {
      shared_.emplace(*settings.ranks, *model_.head, model_.parameters().size());
      sharing = {settings.ranks->size(), [this](int batch) { return trainer_.own_samples(batch); }};
    }
    if (state.optimiser.memory.empty()) state.optimiser = nn::begin(*optimiser_, model_.network);
    feed_.emplace(source, model_.encoding(), model_.targets, preset_.batch, settings.seed,
                  static_cast<int>(state.log.size()), preset_.epochs, std::move(sharing), state.part.trials);
  }

  nn::LoopPosition beginning() const {
    return {static_cast<int>(state_.log.size()), batches_.beginning_at(state_.part.trials), state_.part.loss_sum};
  }
  int batches() const { return batches_.count(); }

  bool wants_epoch(const nn::LoopPosition&) override {
    return settings_.patience == 0 || static_cast<int>(state_.log.size()) - best_epoch(state_.log) < settings_.patience;
  }

  double train_batch(const nn::LoopPosition& at) override {
    const auto values = static_cast<std::size_t>(model_.network.input_shape().size());
    const dataset::Feed::Batch batch = feed_->next();
    trainer_.set_batch(batch.trials);
    parallel_for(batch.own, [&](int i) {
      trainer_.input().load(i, batch.images.subspan(static_cast<std::size_t>(i) * values, values));
    });
    const long long step = 1LL * at.epoch * batches_.count() + at.batch;
    trainer_.set_random(settings_.seed, static_cast<std::uint64_t>(step));
    trainer_.forward();
    const double loss = shared_ ? shared_->of(trainer_, batch, stop_)
                                : model_.head->loss(trainer_.output(), batch.targets, trainer_.output_diff());
    trainer_.backward();
    rate_ = schedule_.rate(step);
    nn::update(*optimiser_, model_.network, trainer_.gradients(), rate_, state_.optimiser);
    if (settings_.average > 0) nn::move_average(*state_.average, model_.network, settings_.average, step + 1);
    return loss;
  }

  bool after_batch(const nn::LoopPosition& at) override {
    if (!std::isfinite(at.loss_sum)) throw diverged(preset_, at.epoch + 1, "the loss is not finite");
    const int done_trials = batches_.first(at.batch);
    stop_ = !after_batch_(done_trials, trials_) || stop_;
    const bool goes_on = shared_ ? !shared_->asked() : !stop_;
    if (!goes_on && done_trials < trials_) state_.part = {done_trials, at.loss_sum};
    return goes_on;
  }

  void end_epoch(const nn::LoopPosition& at) override {
    EpochLog log;
    log.epoch = at.epoch + 1;
    log.learning_rate = rate_;
    log.training_mse = at.loss_sum / (static_cast<double>(trials_) * static_cast<double>(model_.parameters().size()));
    log.validation_mse = validate(source_, trained_model(state_), settings_.ranks);
    for (const auto& [name, mse] : {std::pair("training", log.training_mse), {"validation", log.validation_mse}})
      if (!(mse <= max_mse))
        throw diverged(preset_, at.epoch + 1, format("the %s MSE is %.3g, where guessing the mean gives 1", name, mse));
    state_.log.push_back(log);
    state_.part = {};
  }

  void after_epoch(const nn::LoopPosition&) override { after_epoch_(); }

 private:
  const dataset::TrialSource& source_;
  const TrainingSettings& settings_;
  const Preset& preset_;
  TrainingState& state_;
  Model& model_;
  const AfterBatch& after_batch_;
  const std::function<void()>& after_epoch_;
  int trials_;
  EpochBatches batches_;
  nn::Schedule schedule_;
  std::shared_ptr<const nn::Optimiser> optimiser_;
  nn::Trainer<float> trainer_;
  std::optional<SharedLoss> shared_;
  std::optional<dataset::Feed> feed_;
  double rate_ = 0;
  bool stop_ = false;  // this rank wants to
};

}  // namespace

bool run_training(const dataset::TrialSource& source, const TrainingSettings& settings, TrainingState& state,
                  const std::function<bool(int, int)>& after_batch, const std::function<void()>& after_epoch) {
  ModelTraining training(source, settings, state, after_batch, after_epoch);
  nn::LoopPosition at = training.beginning();
  return nn::run(training, at, settings.preset.epochs, training.batches());
}

}  // namespace decid
