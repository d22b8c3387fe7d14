// The training loop: see training.hpp.
#include "tools/training.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "base/random.hpp"
#include "nn/loss.hpp"
#include "nn/schedule.hpp"
#include "tools/text.hpp"

namespace decid::tools {
namespace {

constexpr auto outputs = sim::parameter_count;

/// Row and target scaling from the first trials of epoch 0, in order.
void measure_scaling(const TrialSource& source, int trials, Model& model) {
  const auto samples = static_cast<std::size_t>(source.protocol().samples());
  const dataset::ImageShape shape = model.images().shape();
  dataset::RowStatistics rows(shape);
  std::vector<sim::Parameters> parameters(static_cast<std::size_t>(trials));
  constexpr int chunk = 64;
  std::vector<float> images(static_cast<std::size_t>(chunk * shape.size()));
  for (int first = 0; first < trials; first += chunk) {
    const int count = std::min(chunk, trials - first);
    const auto image = [&](int i) {
      return std::span(images).subspan(static_cast<std::size_t>(i * shape.size()),
                                       static_cast<std::size_t>(shape.size()));
    };
    parallel_for(count, [&](int i) {
      std::vector<float> sway(samples);
      parameters[static_cast<std::size_t>(first + i)] = source.training_trial(0, first + i, sway);
      if (model.image.standardize_rows) model.images().make(sway, image(i));
    });
    if (model.image.standardize_rows)
      for (int i = 0; i < count; ++i) rows.add(image(i));
  }
  if (model.image.standardize_rows) model.rows = rows.finish();
  model.targets = dataset::target_scaling(parameters);
}

/// The epoch's order of trials: Fisher and Yates, from (seed, epoch).
std::vector<int> shuffled(int count, std::uint64_t seed, int epoch) {
  std::vector<int> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  const Random random(seed, Stream::shuffle, static_cast<std::uint64_t>(epoch));
  for (std::size_t i = order.size(); i-- > 1;) std::swap(order[i], order[random.below(i, i + 1)]);
  return order;
}

double validate(const TrialSource& source, Model& model) {
  const int trials = source.validation_trials();
  const auto samples = static_cast<std::size_t>(source.protocol().samples());
  std::vector<sim::Parameters> truth(static_cast<std::size_t>(trials));
  const auto sway = [&](int i) -> std::span<const float> {
    thread_local std::vector<float> trial;
    trial.resize(samples);
    truth[static_cast<std::size_t>(i)] = source.validation_trial(i, trial);
    return trial;
  };
  const std::vector<float> predicted = predict(model, trials, sway);
  return evaluate(model, predicted, truth).mse();
}

}  // namespace

double Evaluation::mse() const {
  return std::accumulate(mse_per_parameter.begin(), mse_per_parameter.end(), 0.0) / static_cast<double>(outputs);
}

Evaluation evaluate(const Model& model, const std::vector<float>& predicted,
                    const std::vector<sim::Parameters>& truth) {
  Evaluation result;
  result.trials = static_cast<int>(truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const auto target = model.targets.scale(truth[i]);
    for (std::size_t p = 0; p < outputs; ++p) {
      const double error = static_cast<double>(predicted[i * outputs + p]) - static_cast<double>(target[p]);
      result.mse_per_parameter[p] += error * error;
    }
  }
  for (double& mse : result.mse_per_parameter) mse /= static_cast<double>(truth.size());
  return result;
}

std::string log_csv(const std::vector<EpochLog>& log) {
  std::string text = "epoch,training_mse,validation_mse,training_matlab_loss,validation_matlab_loss,learning_rate\n";
  for (const EpochLog& e : log)
    text += format("%d,%.9g,%.9g,%.9g,%.9g,%.9g\n", e.epoch, e.training_mse, e.validation_mse,
                   0.5 * outputs * e.training_mse, 0.5 * outputs * e.validation_mse, e.learning_rate);
  return text;
}

TrainingState start_training(const TrialSource& source, const TrainingSettings& settings) {
  TrainingState state{Model(source.protocol(), settings.preset.image, settings.preset.architecture), {}};
  const int all = source.training_trials();
  measure_scaling(source, settings.scaling_trials > 0 ? std::min(settings.scaling_trials, all) : all, state.model);
  state.model.network.initialise(settings.seed);
  return state;
}

bool run_training(const TrialSource& source, const TrainingSettings& settings, TrainingState& state,
                  const std::function<bool(int, int)>& after_batch, const std::function<void()>& after_epoch) {
  const Preset& preset = settings.preset;
  const int trials = source.training_trials();
  const long long steps = (trials + preset.batch - 1) / preset.batch;
  const nn::Schedule schedule(preset.schedule, preset.learning_rate, steps * preset.epochs, steps,
                              steps * preset.warmup_epochs);
  Model& model = state.model;
  nn::Network<float>& network = model.network;
  const auto samples = static_cast<std::size_t>(source.protocol().samples());
  const auto values = static_cast<std::size_t>(network.input_shape().size());
  std::vector<float> targets(static_cast<std::size_t>(preset.batch) * outputs);

  for (int epoch = static_cast<int>(state.log.size()); epoch < preset.epochs; ++epoch) {
    network.plan(std::min(preset.batch, trials), nn::Mode::training);
    const std::vector<int> order = shuffled(trials, settings.seed, epoch);
    EpochLog log;
    log.epoch = epoch + 1;
    double squares_sum = 0.0;
    for (int first = 0; first < trials; first += preset.batch) {
      const int batch = std::min(preset.batch, trials - first);
      network.set_batch(batch);
      parallel_for(batch, [&](int i) {
        thread_local std::vector<float> sway, image;
        sway.resize(samples);
        image.resize(values);
        const auto target =
            model.targets.scale(source.training_trial(epoch, order[static_cast<std::size_t>(first + i)], sway));
        std::ranges::copy(target, targets.begin() + i * static_cast<std::ptrdiff_t>(outputs));
        model.make_input(sway, image);
        network.input().load(i, image);
      });
      network.forward();
      std::array<double, outputs> squares{};
      nn::mean_squared_error<float>(network.output(),
                                    std::span(targets).first(static_cast<std::size_t>(batch) * outputs), squares,
                                    &network.output_diff());
      network.backward();
      log.learning_rate = schedule.rate(epoch * steps + first / preset.batch);
      nn::sgd_step(network, log.learning_rate, preset.sgd);
      squares_sum += std::accumulate(squares.begin(), squares.end(), 0.0);
      if (!std::isfinite(squares_sum))
        throw Error("training", format("diverged in epoch %d: the loss is not finite", epoch + 1), "lower --lr");
      if (!after_batch(first + batch, trials)) return false;
    }
    log.training_mse = squares_sum / (static_cast<double>(trials) * static_cast<double>(outputs));
    log.validation_mse = validate(source, model);
    state.log.push_back(log);
    after_epoch();
  }
  return true;
}

}  // namespace decid::tools
