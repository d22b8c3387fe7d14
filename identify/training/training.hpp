// The training loop: epochs of shuffled batches, scaling from the training trials, one log line and checkpoint per
// epoch. It resumes to the same bits.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/communicator.hpp"
#include "base/error.hpp"
#include "dataset/source.hpp"
#include "identify/network/model.hpp"
#include "identify/training/log.hpp"
#include "identify/training/presets.hpp"

namespace decid {

struct TrainingSettings {
  Preset preset;                     ///< with the command line's changes
  const Head* head = &point_head();  ///< outlives the training
  std::uint64_t seed = 1;
  int scaling_trials = 0;         ///< training trials that row and target scaling are taken from; 0: all of the epoch
  int patience = 0;               ///< maximum number of epochs in a row without a better validation MSE; 0: never stop
  double average = 0.0;           ///< decay of a moving average of weights that the model gets; 0: none
  Communicator* ranks = nullptr;  ///< processes that share the training; equal bits; null: one process
};

/// The state from which a training continues.
struct TrainingState {
  Model model;
  std::vector<EpochLog> log;                    ///< of the epochs done
  nn::OptimiserState optimiser{};               ///< its momentum buffers; without memory: none yet
  EpochPart part{};                             ///< of the epoch after these, if the training was stopped in its middle
  std::optional<nn::Network<float>> average{};  ///< of the weights (nn/training/average.hpp); empty: none yet, or never
};

/// Returns the model that the training gives if it ends here: with the average of the weights, if it has one.
Model trained_model(const TrainingState& state);

/// Returns a model ready for its first epoch: scaling measured, weights initialised.
TrainingState start_training(const dataset::TrialSource& source, const TrainingSettings& settings);
/// Starts a fine tuning: takes weights, running statistics and scalings from `from`, which errors call `name`. Throws
/// Error unless its architecture, head, image and parameters match the settings; its protocol may differ.
TrainingState start_training(const dataset::TrialSource& source, const TrainingSettings& settings, const Model& from,
                             const std::string& name);

/// Error of a training whose loss has diverged; its model is useless.
struct Diverged : Error {
  using Error::Error;
};
/// Limit of an epoch's mean loss and validation MSE; above it the training has diverged. Guessing the mean gives an MSE
/// of 1.
inline constexpr double max_mse = 1000.0;

/// Copies rank 0's state to all ranks.
void share_state(Communicator& ranks, std::optional<TrainingState>& state);

/// Runs the remaining epochs, or fewer if patience ends. With ranks, every rank makes this call, from the same state.
/// after_batch(samples done in this epoch, samples of an epoch) may return false, at any rank, to stop; then, and only
/// then, the result is false. The state is then the state after the last batch, from which a later call continues to
/// the same bits. Validation is of trained_model(). after_epoch is called when the state is ready to save. Throws
/// Diverged if the loss is not finite or an epoch's loss is above max_mse; the state is useless then.
bool run_training(const dataset::TrialSource& source, const TrainingSettings& settings, TrainingState& state,
                  const std::function<bool(int, int)>& after_batch, const std::function<void()>& after_epoch);

/// MSE of each parameter's z-scored value over trials; the mean over the parameters is "the" MSE.
struct Evaluation {
  std::vector<double> mse_per_parameter;
  int trials = 0;
  double mse() const;
  double matlab_loss() const { return 0.5 * static_cast<double>(mse_per_parameter.size()) * mse(); }
};
/// Compares the network's outputs, z-scores of the parameters of one trial after another, with the trials' true
/// parameters.
Evaluation evaluate(const dataset::TargetScaling& targets, std::span<const float> scores,
                    std::span<const sim::Parameters> truth);

}  // namespace decid
