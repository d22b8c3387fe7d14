// The training loop: epochs of shuffled batches, scaling from the training trials, a log line and a checkpoint an
// epoch, resumable to the same bits.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "dataset/source.hpp"
#include "identify/model.hpp"
#include "identify/training/presets.hpp"

namespace decid {

struct TrainingSettings {
  Preset preset;                     ///< with the command line's changes
  const Head* head = &point_head();  ///< outlives the training
  std::uint64_t seed = 1;
  int scaling_trials = 0;  ///< training trials that row and target scaling are taken from; 0: all of the epoch
  int patience = 0;        ///< stop after so many epochs in a row without a better validation MSE; 0: never
};

/// One line of the log. MSE: the loss of the model's head, a trial and parameter, which is a mean squared error.
/// MATLAB's regression loss is half the sum over the parameters.
struct EpochLog {
  int epoch = 0;                ///< from 1
  double training_mse = 0.0;    ///< mean over the epoch's batches, as they were trained
  double validation_mse = 0.0;  ///< with running statistics, after the epoch
  double learning_rate = 0.0;   ///< of the epoch's last step
};
std::string log_csv(const std::vector<EpochLog>& log, std::size_t parameters);

/// The epoch of the least validation MSE, the first of equals; 0 if there is none yet.
int best_epoch(const std::vector<EpochLog>& log);

/// What a training needs to go on.
struct TrainingState {
  Model model;
  std::vector<EpochLog> log;           ///< of the epochs done
  nn::Velocities<float> velocities{};  ///< of the optimiser; empty: none yet
};

/// A model ready for its first epoch: scaling measured, weights initialised.
TrainingState start_training(const dataset::TrialSource& source, const TrainingSettings& settings);

/// Runs the remaining epochs, or fewer if patience ends. after_batch(samples done in this epoch, samples of an
/// epoch) may return false to stop; then, and only then, the result is false. after_epoch is called with the state as
/// it is worth keeping. Throws Error if the loss is no longer finite.
bool run_training(const dataset::TrialSource& source, const TrainingSettings& settings, TrainingState& state,
                  const std::function<bool(int, int)>& after_batch, const std::function<void()>& after_epoch);

/// MSE of each parameter's z-scored value over trials; the mean over the parameters is "the" MSE.
struct Evaluation {
  std::vector<double> mse_per_parameter;
  int trials = 0;
  double mse() const;
  double matlab_loss() const { return 0.5 * static_cast<double>(mse_per_parameter.size()) * mse(); }
};
/// Compares `scores` (see scores_of) with the trials' true parameters.
Evaluation evaluate(const dataset::TargetScaling& targets, std::span<const float> scores,
                    std::span<const sim::Parameters> truth);

}  // namespace decid
