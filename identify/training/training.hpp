// The training loop: epochs of shuffled batches, scaling from the training trials, a log line and a checkpoint an
// epoch, resumable to the same bits.
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
  int patience = 0;               ///< stop after so many epochs in a row without a better validation MSE; 0: never
  Communicator* ranks = nullptr;  ///< processes that share the training, with the bits of one alone; null: none do
};

/// What a training needs to go on.
struct TrainingState {
  Model model;
  std::vector<EpochLog> log;                      ///< of the epochs done
  nn::MomentumBuffers<float> momentum_buffers{};  ///< of the optimiser; empty: none yet
  EpochPart part{};  ///< of the epoch after these, if the training was stopped in its middle
};

/// A model ready for its first epoch: scaling measured, weights initialised.
TrainingState start_training(const dataset::TrialSource& source, const TrainingSettings& settings);
/// Fine tuning: weights, running statistics and scalings are those of `from`, which errors call `name`. Throws Error
/// unless its architecture, head, image and parameters are those of the settings; its protocol may be another one.
TrainingState start_training(const dataset::TrialSource& source, const TrainingSettings& settings, const Model& from,
                             const std::string& name);

/// A training whose loss has left all bounds; what it made is worth nothing.
struct Diverged : Error {
  using Error::Error;
};
/// Guessing the mean gives an MSE of 1. An epoch's mean loss or validation MSE above this has diverged.
inline constexpr double max_mse = 1000.0;

/// Gives rank 0's state to all.
void share_state(Communicator& ranks, std::optional<TrainingState>& state);

/// Runs the remaining epochs, or fewer if patience ends. With ranks all make this call, from the same state.
/// after_batch(samples done in this epoch, samples of an epoch) may return false, at any rank, to stop; then, and only
/// then, the result is false, and the state that after the last batch, from which a later call goes on to the same
/// bits. after_epoch is called with the state as it is worth keeping. Throws Diverged if the loss is no longer finite
/// or an epoch's above max_mse; the state is worth nothing then.
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
