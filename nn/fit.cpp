// Training in one call: see fit.hpp.
#include "nn/fit.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <utility>
#include <variant>

#include "base/batches.hpp"
#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/sha256.hpp"
#include "base/parallel.hpp"
#include "base/text.hpp"
#include "nn/detail/samples.hpp"
#include "nn/operation.hpp"
#include "nn/training/average.hpp"
#include "nn/training/detail/fit_checkpoint.hpp"
#include "nn/training/loop.hpp"
#include "nn/training/schedule.hpp"
#include "nn/training/trainer.hpp"

namespace decid::nn {
namespace {

constexpr double max_rate = 1e6;           // Schedule's
constexpr double max_warmup_epochs = 1e6;  // so that their steps are a long long

/// Throws Error for settings out of their ranges. lines: how many the network's architecture has.
void check(const FitOptions& o, std::size_t lines) {
  const auto refuse = [](const char* name, double value, const std::string& allowed) {
    throw Error(Code::setting_out_of_range, "fit", format("has the setting %s = %g", name, value), "give " + allowed);
  };
  if (o.epochs < 1) refuse("epochs", o.epochs, "1 or more");
  if (o.batch < 1) refuse("batch", o.batch, "1 or more samples");
  if (!(o.learning_rate > 0 && o.learning_rate < max_rate))
    refuse("learning_rate", o.learning_rate, format("a number above 0 and below %g", max_rate));
  if (!(o.warmup_epochs >= 0 && o.warmup_epochs <= max_warmup_epochs))
    refuse("warmup_epochs", o.warmup_epochs, format("0 to %g epochs", max_warmup_epochs));
  if (!(o.clip_norm >= 0)) refuse("clip_norm", o.clip_norm, "0 for none, or a norm");
  if (!(o.average >= 0 && o.average < 1)) refuse("average", o.average, "0 for none, or a decay below 1");
  if (o.frozen_lines < 0 || static_cast<std::size_t>(o.frozen_lines) > lines)
    refuse("frozen_lines", o.frozen_lines,
           "0 to the " + counted(static_cast<long long>(lines), "line") + " of the network's architecture");
  if (!(o.validation >= 0 && o.validation < 1)) refuse("validation", o.validation, "a fraction from 0 to below 1");
  if (o.patience < 0) refuse("patience", o.patience, "0 for never, or a number of epochs");
  if (o.loss == nullptr || o.optimiser == nullptr)
    throw Error(Code::setting_missing, "fit", "has no loss or no optimiser",
                "leave the defaults, or give one such as nn::cross_entropy()");
}

bool has_finite_weights(const Network<float>& network) {
  return std::ranges::all_of(network.layers(), [](const Layer<float>& layer) {
    const auto finite = [](const auto& tensor) { return is_finite(tensor.value); };
    return std::ranges::all_of(layer.parameters(), finite) && std::ranges::all_of(layer.statistics(), finite);
  });
}

/// Returns true for a network with the values that its constructor gave it.
bool is_new(const Network<float>& network) {
  return std::ranges::all_of(network.layers(), [](const Layer<float>& layer) {
    const auto untouched = [](const auto& tensor) {
      return std::ranges::all_of(tensor.value, [&](float value) { return value == tensor.initial; });
    };
    return std::ranges::all_of(layer.parameters(), untouched) && std::ranges::all_of(layer.statistics(), untouched);
  });
}

/// Returns true for a layer whose weights and biases are all 0; false for one without weights.
bool is_zero(const Layer<float>& layer) {
  const auto all_zero = [](const Parameter<float>& parameter) {
    return std::ranges::all_of(parameter.value, [](float value) { return value == 0; });
  };
  return std::ranges::any_of(layer.parameters(), [](const Parameter<float>& p) { return p.fan_in > 0; }) &&
         std::ranges::all_of(layer.parameters(), all_zero);
}

/// Returns true if the layer's outputs are all 0 for inputs of 0, as training computes them.
bool maps_zero_to_zero(const Layer<float>& layer) {
  const auto all = [&](std::size_t parameter, const auto& test) {
    return std::ranges::all_of(layer.parameters()[parameter].value, test);
  };
  const auto is_0 = [](float value) { return value == 0; };
  const LayerKind& kind = layer.kind();
  if (std::holds_alternative<Conv2d>(kind) || std::holds_alternative<FullyConnected>(kind)) return all(1, is_0);
  if (const auto* norm = std::get_if<BatchNorm>(&kind))
    return norm->relu ? all(1, [](float beta) { return beta <= 0; }) : all(1, is_0);
  if (std::holds_alternative<StatisticsPool>(kind) || std::holds_alternative<Join>(kind)) return false;
  const auto* extension = std::get_if<Extension>(&kind);
  if (extension == nullptr) return true;  // relu and pools
  const Operation& operation = *extension->operation;
  AlignedBuffer<float> in, out;
  in.reserve(TensorView<float>::required(operation.src(), 1, operation.src_halo()));
  out.reserve(TensorView<float>::required(operation.dst(), 1, {}));
  std::vector<std::span<const float>> parameters;
  for (const Parameter<float>& parameter : layer.parameters()) parameters.emplace_back(parameter.value);
  const TensorView<float> outputs(out.data(), operation.dst(), 1, {});
  operation.forward(ForwardPass<float>{
      TensorView<float>(in.data(), operation.src(), 1, operation.src_halo()), outputs, parameters, {}});
  std::vector<float> values(static_cast<std::size_t>(operation.dst().size()));
  outputs.store(0, values);
  return std::ranges::all_of(values, is_0);
}

/// Returns true for a relu, also one behind a BatchNorm.
bool rectifies(const LayerKind& kind) {
  const auto* norm = std::get_if<BatchNorm>(&kind);
  return std::holds_alternative<Relu>(kind) || (norm != nullptr && norm->relu);
}

/// Throws Error if two zero layers follow each other in one chain, or if a relu reads only the zeros of a zero layer:
/// no gradient reaches their weights. The layers of a residual or concat are a chain of their own, because its input
/// bypasses them. frozen_lines: as FitOptions'.
void require_gradients(const Network<float>& network, int frozen_lines) {
  struct Chain {
    int zeros = 0;
    std::optional<std::size_t> silent = {};  // the line of the zero layer because of which all values are 0 here
  };
  const auto refuse = [](const std::string& problem, const char* remedy) {
    throw Error(Code::setting_missing, "fit",
                "has " + problem + ", but other weights are set: no gradient reaches them", remedy);
  };
  std::vector<Chain> open{{}};  // the innermost last
  std::size_t line = 0;
  for (const Layer<float>& layer : network.layers()) {
    if (std::holds_alternative<Branch>(layer.kind())) open.emplace_back();
    if (std::holds_alternative<Join>(layer.kind())) open.pop_back();
    Chain& chain = open.back();
    const bool passes_zeros = maps_zero_to_zero(layer);
    if (chain.silent && passes_zeros && rectifies(layer.kind()))
      refuse(format("weights that are all 0 in line %zu, before a relu", *chain.silent + 1),
             "call initialise() before copying weights, or give this layer other weights");
    if (!passes_zeros) chain.silent.reset();
    if (is_zero(layer)) {
      if (++chain.zeros == 2)
        refuse(format("two layers whose weights are all 0, the second in line %zu", line + 1),
               "call initialise() before copying weights, or leave only one layer at 0");
      if (static_cast<int>(line) >= frozen_lines) chain.silent = line;
    }
    line += layer.lines();
  }
}

class Fit final : public TrainingLoop {
 public:
  Fit(Network<float>& network, const Samples& samples, const FitOptions& options, std::vector<int> training,
      std::vector<int> validation)
      : network_(network),
        samples_(samples),
        options_(options),
        training_(std::move(training)),
        validation_(std::move(validation)),
        batches_(static_cast<int>(training_.size()), options.batch),
        schedule_(options.schedule, options.learning_rate, 1LL * batches_.count() * options.epochs, batches_.count(),
                  std::llround(options.warmup_epochs * batches_.count()), Schedule::CosineFrom::warmup_end),
        trainer_(network, batches_.size(0)),
        width_(static_cast<std::size_t>(options.loss->targets(network.output_shape().size()))),
        state{begin(*options.optimiser, network), {}, {}, std::nullopt, std::nullopt, 0} {
    options.loss->require(network.output_shape());
    require_targets(samples, *options.loss, network.output_shape().size());
    if (options.validation_samples)
      require_targets(*options.validation_samples, *options.loss, network.output_shape().size());
    if (!options.checkpoint.empty()) {
      content_ = content_of(samples);
      if (options.validation_samples) content_ += " and " + content_of(*options.validation_samples);
    }
    require_smallest_batch();
    if (options.average > 0) state.average = network;
    std::size_t line = 0, k = 0;
    Sha256 hash;
    for (const Layer<float>& layer : std::as_const(network).layers()) {
      const bool is_frozen = static_cast<int>(line) < options.frozen_lines;
      for (const Parameter<float>& parameter : layer.parameters()) {
        gradients_.push_back(is_frozen ? std::span<float>() : trainer_.gradient(k));
        ++k;
        if (is_frozen) hash.update(parameter.value.data(), parameter.value.size() * sizeof(float));
      }
      line += layer.lines();
    }
    if (options.frozen_lines > 0) frozen_ = " of SHA-256 " + hash.hex();
  }

  int batches() const { return batches_.count(); }

  bool wants_epoch(const LoopPosition& at) override {
    return options_.patience == 0 || at.epoch - state.best_epoch < options_.patience;
  }

  void load_batch(const LoopPosition& at) override {
    if (at.batch == 0 || order_.empty()) order_ = shuffled(static_cast<int>(training_.size()), options_.seed, at.epoch);
    places_.clear();
    for (int i = batches_.first(at.batch); i < batches_.first(at.batch + 1); ++i)
      places_.push_back(training_[static_cast<std::size_t>(order_[static_cast<std::size_t>(i)])]);
    const std::size_t values = input_values();
    const auto random = [&](int sample) {
      const auto epoch = static_cast<std::uint64_t>(at.epoch), number = static_cast<std::uint64_t>(sample);
      return Random(options_.seed, Stream::augmentation, epoch << 32U | number);
    };
    const auto load_all = [&] { load(samples_, places_, values, width_, at.epoch + 1, random, loaded_); };
    if (samples_.load_batch())
      load_all();  // the function may have parallel loops of its own
    else
      with_team(load_all);
    if (samples_.inputs().empty()) require_finite(loaded_, places_, values, width_);
  }

  double train_batch(const LoopPosition& at) override {
    const std::size_t values = input_values();
    trainer_.set_batch(static_cast<int>(places_.size()));
    parallel_for(static_cast<int>(places_.size()), [&](int i) {
      trainer_.input().load(
          i, std::span<const float>(loaded_.inputs).subspan(static_cast<std::size_t>(i) * values, values));
    });
    const long long step = 1LL * at.epoch * batches_.count() + at.batch;
    trainer_.set_random(options_.seed, static_cast<std::uint64_t>(step));
    trainer_.forward();
    const double loss = total_loss<float>(*options_.loss, trainer_.output(), loaded_.targets, trainer_.output_diff());
    if (!std::isfinite(loss)) diverge(at, "the loss is not finite");
    trainer_.backward();
    if (options_.clip_norm > 0) clip(gradients_, options_.clip_norm);
    rate_ = schedule_.rate(step);
    const std::vector<std::span<const float>> gradients(gradients_.begin(), gradients_.end());
    update(*options_.optimiser, network_, gradients, rate_, state.optimiser);
    if (state.average) move_average(*state.average, network_, options_.average, state.optimiser.steps);
    last_loss_ = loss / static_cast<double>(places_.size());
    return loss;
  }

  bool after_batch(const LoopPosition& at) override {
    return !options_.after_batch || options_.after_batch(at.epoch + 1, at.batch, last_loss_);
  }

  void end_epoch(const LoopPosition& at) override {
    const Network<float>& now = state.average ? *state.average : network_;
    FitEpoch epoch{at.epoch + 1, at.loss_sum / static_cast<double>(training_.size()),
                   std::numeric_limits<double>::quiet_NaN(), rate_};
    if (!validation_.empty())
      epoch.validation_loss = mean_loss_of(now, options_.validation_samples ? *options_.validation_samples : samples_,
                                           validation_, epoch.epoch, *options_.loss);
    if (!validation_.empty() && !std::isfinite(epoch.validation_loss)) diverge(at, "the validation loss is not finite");
    require_finite_weights(at);
    const auto best = static_cast<std::size_t>(state.best_epoch);
    if (options_.patience > 0 && (best == 0 || epoch.validation_loss < state.log[best - 1].validation_loss)) {
      state.best_epoch = epoch.epoch;
      state.best = now;
    }
    state.log.push_back(epoch);
  }

  void after_epoch(const LoopPosition& at) override {
    save(at);
    if (options_.after_epoch) options_.after_epoch(state.log.back());
  }

  /// Throws Error if the last step, or the average of steps, left a weight that is not finite.
  void require_finite_weights(const LoopPosition& at) const {
    if (!has_finite_weights(network_) || (state.average && !has_finite_weights(*state.average)))
      diverge(at, "a weight is not finite");
  }

  void save(const LoopPosition& at) {
    state.at = at;
    if (!options_.checkpoint.empty()) save_checkpoint(network_, state, description(), options_.checkpoint);
  }
  /// Continues from the checkpoint. Returns false if there is none.
  bool resume() {
    if (options_.checkpoint.empty() || !path_exists(options_.checkpoint)) return false;
    load_checkpoint(network_, state, description(), options_.checkpoint);
    return true;
  }

  /// Describes everything that determines the bits, except samples of a function and callbacks.
  std::string description() const {
    const FitOptions& o = options_;
    const char* const then = o.warmup_epochs > 0 && o.schedule == "cosine" ? " and then the cosine" : "";
    return format("epochs %d, batch %d, learning rate %.17g, schedule %s, warm-up %.17g%s, loss %s, optimiser %s, ",
                  o.epochs, o.batch, o.learning_rate, o.schedule.c_str(), o.warmup_epochs, then, o.loss->text().c_str(),
                  o.optimiser->text().c_str()) +
           format("clip norm %.17g, average %.17g, frozen lines %d%s, patience %d, seed %llu, samples %zu and %zu",
                  o.clip_norm, o.average, o.frozen_lines, frozen_.c_str(), o.patience,
                  static_cast<unsigned long long>(o.seed), training_.size(), validation_.size()) +
           " of " + content_;
  }

  /// Gives the network its final weights.
  void keep() {
    if (state.best)
      network_ = *state.best;
    else if (state.average)
      network_ = *state.average;
  }

 private:
  /// Throws Error before the first step if the network cannot train on the smallest batch.
  void require_smallest_batch() {
    const auto samples = static_cast<int>(training_.size());
    try {
      trainer_.set_batch(batches_.min_size());
    } catch (const Error& error) {
      if (options_.batch == 1 || batches_.count() == 1) throw;
      int enough = options_.batch + 1;
      while (EpochBatches(samples, enough).min_size() == batches_.min_size()) ++enough;
      throw Error(error.code(), error.where(), error.problem(),
                  format("%d samples to train on in batches of at most %d leave one of %d: give a batch of %d", samples,
                         options_.batch, batches_.min_size(), enough));
    }
  }

  std::size_t input_values() const { return static_cast<std::size_t>(network_.input_shape().size()); }

  [[noreturn]] void diverge(const LoopPosition& at, const char* problem) const {
    throw Error(Code::diverged, "fit", format("diverged in epoch %d: %s", at.epoch + 1, problem),
                format("lower the learning rate of %g, or clip gradients", options_.learning_rate));
  }

  Network<float>& network_;
  const Samples& samples_;
  const FitOptions& options_;
  std::vector<int> training_, validation_;  // places in samples
  EpochBatches batches_;
  Schedule schedule_;
  Trainer<float> trainer_;
  std::size_t width_;
  std::vector<std::span<float>> gradients_;  // empty: frozen
  std::string content_;                      // of the samples, for checkpoints
  std::string frozen_;                       // parameters, which a checkpoint of another network's would replace
  std::vector<int> order_, places_;          // of an epoch's samples; of a batch's in samples
  Loaded loaded_;
  double rate_ = 0, last_loss_ = 0;

 public:
  FitState state;
};

}  // namespace

FitLog fit(Network<float>& network, const Samples& samples, const FitOptions& options) {
  std::size_t lines = 0;
  for (const Layer<float>& layer : std::as_const(network).layers()) lines += layer.lines();
  check(options, lines);
  require_finite(samples);
  if (options.validation_samples) require_finite(*options.validation_samples);
  if (is_new(network)) network.initialise(options.seed);
  // A random part, the same at every call: it uses the order of an epoch that never runs.
  std::vector<int> training = shuffled(samples.count(), options.seed, -1), validation;
  if (options.validation_samples) {
    validation = all_of(*options.validation_samples);
  } else if (options.validation > 0) {
    const auto count = static_cast<std::ptrdiff_t>(std::llround(options.validation * samples.count()));
    validation.assign(training.begin(), training.begin() + count);
    training.erase(training.begin(), training.begin() + count);
  }
  if (options.patience > 0 && validation.empty())
    throw Error(Code::setting_conflict, "fit",
                format("has a patience of %d, but validates none of %d samples", options.patience, samples.count()),
                "raise validation, give validation_samples, or leave patience at 0");
  if (training.empty()) throw Error(Code::trials_missing, "fit", "has no sample to train on", "validate fewer of them");
  std::ranges::sort(training);
  std::ranges::sort(validation);
  Fit fit(network, samples, options, std::move(training), std::move(validation));
  if (!fit.resume()) require_gradients(network, options.frozen_lines);
  LoopPosition at = fit.state.at;
  FitLog log;
  log.finished = run(fit, at, options.epochs, fit.batches());
  if (!log.finished) fit.require_finite_weights(at);
  if (!log.finished) fit.save(at);  // before keep(): the next call goes on from the weights of the last step
  fit.keep();
  log.epochs = fit.state.log;
  log.kept = options.patience > 0 ? fit.state.best_epoch : static_cast<int>(log.epochs.size());
  return log;
}

}  // namespace decid::nn
