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
#include "nn/training/batch_partition.hpp"
#include "nn/training/schedule.hpp"
#include "nn/training/trainer.hpp"

namespace decid {
namespace {

double validate(const dataset::TrialSource& source, const Model& model, Communicator* ranks) {
  const Predicted predicted = predict(model, source, dataset::Part::validation, ranks);
  return evaluate(model.targets, predicted.scores, predicted.truth).mse();
}

/// Puts together what all ranks have of a batch's loss.
class SharedLoss {
 public:
  SharedLoss(Communicator& ranks, const Head& head, std::size_t parameters)
      : ranks_(ranks), head_(head), parameters_(parameters), width_(head.loss_parts(parameters)) {}

  /// The loss of the whole batch. stop: whether this rank wants to; asked() says whether any does.
  double of(nn::Trainer<float>& trainer, const dataset::Feed::Batch& batch, bool stop) {
    const nn::BatchPartition& share = share_of(batch.trials);
    own_.assign(share.blocks.size() * width_ + 1, 0.0);
    head_.loss(trainer.output(), batch.targets, batch.trials, parameters_, std::span(own_).subspan(1),
               trainer.output_diff());
    own_.front() = stop ? 1.0 : 0.0;
    std::vector<std::size_t> place, sizes;  // of each rank's next value, and of all its bytes
    std::size_t count = 0;
    for (int rank = 0; rank < ranks_.size(); ++rank) {
      place.push_back(count + 1);
      const auto blocks = static_cast<std::size_t>(std::ranges::count(share.owner, rank));
      count += blocks * width_ + 1;
      sizes.push_back((blocks * width_ + 1) * sizeof(double));
    }
    all_.resize(count);
    ranks_.all_gather(std::as_bytes(std::span(own_)), sizes, std::as_writable_bytes(std::span(all_)));
    asked_ = std::ranges::any_of(place, [&](std::size_t first) { return all_[first - 1] != 0.0; });
    parts_.clear();
    for (const int owner : share.owner) {
      std::size_t& first = place[static_cast<std::size_t>(owner)];
      for (std::size_t i = 0; i < width_; ++i) parts_.push_back(all_[first++]);
    }
    return head_.total_loss(parts_, parameters_);
  }
  bool asked() const { return asked_; }

 private:
  const nn::BatchPartition& share_of(int batch) {
    const auto [found, is_new] = shares_.try_emplace(batch);
    if (is_new)
      found->second =
          nn::share_of(static_cast<int>(nn::TensorView<float>::blocks_of(batch)), ranks_.rank(), ranks_.size());
    return found->second;
  }

  Communicator& ranks_;
  const Head& head_;
  std::size_t parameters_, width_;
  std::vector<double> own_, all_, parts_;
  std::map<int, nn::BatchPartition> shares_;
  bool asked_ = false;
};

/// Lines joined by semicolons, as an architecture may be written too.
std::string in_a_line(const std::string& text) {
  std::string line;
  for (const char c : text) line += c == '\n' ? "; " : std::string(1, c);
  return line;
}

Diverged diverged(const Preset& preset, int epoch, const std::string& how) {
  return Diverged("training", format("diverged in epoch %d of %d: ", epoch, preset.epochs) + how,
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
        name,
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
  nn::TensorFile weights;
  nn::save_network(from.network, weights);
  nn::load_network(model.network, std::move(weights), name);
  return state;
}

void share_state(Communicator& ranks, std::optional<TrainingState>& state) {
  if (ranks.is_root() && state->momentum_buffers.empty())
    for (const nn::Parameter<float>* p : state->model.network.parameters())
      state->momentum_buffers.emplace_back(p->value.size());
  const std::string bytes = broadcast_text(ranks, ranks.is_root() ? checkpoint_bytes(*state) : std::string());
  if (!ranks.is_root()) state = state_from_bytes(bytes);
}

bool run_training(const dataset::TrialSource& source, const TrainingSettings& settings, TrainingState& state,
                  const std::function<bool(int, int)>& after_batch, const std::function<void()>& after_epoch) {
  const Preset& preset = settings.preset;
  const int trials = source.trials(dataset::Part::training);
  const EpochBatches batches(trials, preset.batch);
  const long long steps = batches.count();
  const nn::Schedule schedule(preset.schedule, preset.learning_rate, steps * preset.epochs, steps,
                              steps * preset.warmup_epochs);
  Model& model = state.model;
  nn::Trainer<float> trainer(model.network, batches.size(0), settings.ranks);
  trainer.set_batch(batches.smallest());  // throws before the first step, not at the epoch's end
  std::optional<SharedLoss> shared;
  dataset::BatchSharing sharing;
  if (settings.ranks != nullptr) {
    shared.emplace(*settings.ranks, *model.head, model.parameters().size());
    sharing = {settings.ranks->size(), [&](int batch) { return trainer.own_samples(batch); }};
  }
  if (!state.momentum_buffers.empty()) trainer.set_velocities(state.momentum_buffers);
  const auto values = static_cast<std::size_t>(model.network.input_shape().size());
  const int done = static_cast<int>(state.log.size());
  int first_batch = batches.beginning_at(state.part.trials);
  dataset::Feed feed(source, model.encoding(), model.targets, preset.batch, settings.seed, done, preset.epochs,
                     std::move(sharing), state.part.trials);
  bool stop = false;  // this rank wants to

  const auto patient = [&] {
    return settings.patience == 0 || static_cast<int>(state.log.size()) - best_epoch(state.log) < settings.patience;
  };
  for (int epoch = done; epoch < preset.epochs && patient(); ++epoch) {
    EpochLog log;
    log.epoch = epoch + 1;
    double loss_sum = state.part.loss_sum;
    for (int number = first_batch; number < batches.count(); ++number) {
      const int done_trials = batches.first(number + 1);
      const dataset::Feed::Batch batch = feed.next();
      trainer.set_batch(batch.trials);
      parallel_for(batch.own, [&](int i) {
        trainer.input().load(i, batch.images.subspan(static_cast<std::size_t>(i) * values, values));
      });
      trainer.forward();
      loss_sum += shared ? shared->of(trainer, batch, stop)
                         : model.head->loss(trainer.output(), batch.targets, trainer.output_diff());
      trainer.backward();
      log.learning_rate = schedule.rate(epoch * steps + number);
      trainer.step(log.learning_rate, preset.sgd);
      if (!std::isfinite(loss_sum)) throw diverged(preset, epoch + 1, "the loss is not finite");
      stop = !after_batch(done_trials, trials) || stop;
      if (shared ? shared->asked() : stop) {
        if (done_trials == trials) break;  // but for its validation the epoch is done
        state.momentum_buffers = trainer.momentum_buffers();
        state.part = {done_trials, loss_sum};
        return false;
      }
    }
    log.training_mse = loss_sum / (static_cast<double>(trials) * static_cast<double>(model.parameters().size()));
    log.validation_mse = validate(source, model, settings.ranks);
    for (const auto& [name, mse] : {std::pair("training", log.training_mse), {"validation", log.validation_mse}})
      if (!(mse <= max_mse))
        throw diverged(preset, epoch + 1, format("the %s MSE is %.3g, where guessing the mean gives 1", name, mse));
    state.log.push_back(log);
    state.part = {};
    first_batch = 0;
    state.momentum_buffers = trainer.momentum_buffers();
    after_epoch();
    if (shared ? shared->asked() : stop) return false;
  }
  return true;
}

}  // namespace decid
